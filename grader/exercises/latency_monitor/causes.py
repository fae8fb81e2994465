"""What is odd about reports, for exercise 9: a key again and again, or a slip of units."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise

from grader.checks.case import wrong_unit
from grader.checks.verdict import Evidence, Trials
from grader.exercises.latency_monitor.reports import DIAGNOSTICS, NAME, TOPIC, cases
from sim.messages import decode

OF_REPORTS = ("mean_and_max", "window", "raised_calls", "percentiles", "missed", "stale_at_first",
              "status_form", "levels")  # fmt: skip
LEAST = 3  # reports
TIMES = ("deadline_ms", "mean_ms", "max_ms", "p50_ms")


def seen(trials: Trials, failed: Sequence[str]) -> Evidence | None:
    """Return that a status has several values of one name, or that times are in another unit."""
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
    for name, run in trials.items() if explained else ():
        values = [case for case in cases(run) if "form" not in case.tags]
        counts = [(case.at, case.said["count"]) for case in values
                  if "count" in case.tags and "count" in case.said]  # fmt: skip
        for (_, before), (at, count) in pairwise(counts):
            if isinstance(before, float) and isinstance(count, float) and count < before:
                return Evidence(
                    f"at {at:.2f} s of {name} count falls from {before:.9g} to {count:.9g}: a call "
                    "leaves the window only when a hundred later ones are in it. What empties it?",
                    explains=explained,
                )
        for text in filter(None, (wrong_unit(values, field) for field in TIMES)):
            return Evidence(f"in the reports of {name} {text}", explains=explained)
        told = [case.said["max_ms"] for case in values  # where there were calls
                if "max_ms" in case.tags and "max_ms" in case.said]  # fmt: skip
        if len(told) >= LEAST and not any(told):
            return Evidence(
                f"in the reports of {name} every latency is 0.00, whatever the calls took. Is it "
                "measured around predict, and does nothing make whole seconds of it (int(…), // or "
                "the seconds of a timedelta)?",
                explains=explained,
            )
    return None
