"""What exercise 4's recordings show of a mistake: no closing speed ever comes."""

from __future__ import annotations

from collections.abc import Sequence

from grader.checks.evidence import Evidence, Trials

FULL = 12  # readings; a memory of ten is full


def seen(trials: Trials, failed: Sequence[str]) -> Evidence | None:
    """Return that no closing speed comes, if none does."""
    text = _never_ten(trials)
    return Evidence(text, hint="3.4", explains=failed) if text else None


def _never_ten(trials: Trials) -> str:
    """A memory that never has ten readings."""
    recording = trials.get("trend_approach")
    if recording is None or len(recording.scans()) < FULL or not len(recording.twists().t):
        return ""
    if len(recording.of("/closing_speed")):
        return ""
    return (
        f"not one closing speed comes in the {len(recording.scans())} scans of trend_approach. "
        "Does the node wait for more than ten readings, which a memory of ten never has? Is its "
        "memory emptied again and again, as the stamp is not in seconds, sec + nanosec * 1e-9?"
    )
