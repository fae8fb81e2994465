"""What a supervisor does while a stop is due, for exercise 7: seen in its commands, with the times.

It speaks only if the node never heeds the stop in any run that asks for it; one that forgets it
later, or in one case, is told by the checks.
"""

from __future__ import annotations

from collections.abc import Sequence

from grader.checks.commands import ZERO, spell
from grader.checks.verdict import Evidence, Trials
from grader.exercises.safety_supervisor.contract import cases
from sim.messages import BOOL, E_STOP_TOPIC, decode

LEAST = 5  # occasions
RUN = "safe_e_stop"
EXPLAINS = ("e_stop", "reasons", "first_match", "e_stop_at_once")


def seen(trials: Trials, failed: Sequence[str]) -> Evidence | None:
    """Return that no /e_stop stops the robot, if so; with the moment of the first."""
    run = trials.get(RUN)
    if run is None or not run.outcome.completed or "e_stop" not in failed:
        return None
    due = [case for case in cases(run) if "e_stop" in case.tags and "linear.x" in case.said]
    pressed = [
        message.time / 1e9
        for message in run.delivered
        if message.topic == E_STOP_TOPIC and decode(message.data, BOOL).data
    ]
    drove = [case for case in due if abs(float(case.said["linear.x"])) > ZERO]
    if len(due) < LEAST or len(drove) < len(due) or not pressed:
        return None
    at = max((t for t in pressed if t <= due[0].at), default=pressed[0])
    return Evidence(
        f"after /e_stop true at {at:.2f} s of {RUN} the robot drove on at "
        f"{spell(float(drove[0].said['linear.x']))} m/s, and it never stands while that is true. "
        "Is the callback of /e_stop called, does it keep the message's data in the attribute that "
        "the timer reads, and is that a bool, not a text?",
        explains=EXPLAINS,
    )
