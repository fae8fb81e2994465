"""What exercise 7's recordings show of a mistake: everything is too old."""

from __future__ import annotations

from collections.abc import Sequence

from grader.checks.evidence import Evidence, Trials
from grader.checks.reading import published

STALE = "stale_"  # begins the reasons for what is too old
SETTLED = 0.6  # [s] after the start


def seen(trials: Trials, failed: Sequence[str]) -> Evidence | None:
    """Return that everything is reported as too old, if it is."""
    text = _always_stale(trials)
    return Evidence(text, hint="1.2", explains=failed) if text else None


def _always_stale(trials: Trials) -> str:
    """A node that finds everything too old, though it comes all the time."""
    recording = trials.get("safe_pass")
    if recording is None:
        return ""
    texts = [
        str(value.status[0].message)
        for time, value in published(
            recording, "/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"
        )
        if time > SETTLED and value.status
    ]
    if not texts or not all(text.startswith(STALE) for text in texts):
        return ""
    reason = texts[0].split()[0].rstrip(":")
    return (
        f"all {len(texts)} reports of safe_pass after {SETTLED} s begin with {STALE} ({reason} at "
        "first), though messages keep coming. Are ages in seconds? A Duration counts nanoseconds "
        "(divide by 1e9). And is each arrival kept, by the clock that it is compared with?"
    )
