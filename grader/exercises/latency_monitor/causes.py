"""What is odd about a report's values, for exercise 9: the same key again and again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from grader.checks.verdict import Evidence, Trials
from grader.exercises.latency_monitor.reports import DIAGNOSTICS, NAME, TOPIC
from sim.messages import decode

OF_REPORTS = ("mean_and_max", "window", "raised_calls", "percentiles", "missed", "stale_at_first",
              "status_form", "levels")  # fmt: skip


def seen(trials: Trials, failed: Sequence[str]) -> Evidence | None:
    """Return that a status has several values of one name, with the first such report."""
    explained = [check for check in failed if check in OF_REPORTS]
    for run in trials.values() if explained else ():
        for message in run.published:
            if message.topic != TOPIC or message.type != DIAGNOSTICS:
                continue
            try:
                statuses = decode(message.data, DIAGNOSTICS).status
            except ValueError:
                return None  # the checks say so
            keys = Counter(v.key for each in statuses if each.name == NAME for v in each.values)
            for key, times in keys.most_common(1):
                if times > 1:
                    return Evidence(
                        f"the report at {message.time / 1e9:.2f} s of {run.name} has "
                        f"{keys.total()} values, of which {times} are named {key[:40]}. Is one "
                        "KeyValue filled and appended again and again? Make a new one for each "
                        "value: KeyValue(key=…, value=…).",
                        explains=explained,
                    )
                break
    return None
