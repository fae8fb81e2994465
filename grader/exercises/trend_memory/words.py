"""The words of exercise 4 alone: when closing speeds come, and what the node says."""

from __future__ import annotations

from dataclasses import replace

from grader.checks.case import Case, Runs
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.checks.words import TOLERANCE, reacts, require_allowed
from grader.exercises.trend_memory.contract import TOPIC
from sim.messages import CMD_VEL_TOPIC

PACED = ("filling", "refilling", "unusable", "full")


def keeps_pace(runs: Runs, *tags: str, help: str = "") -> None:
    """Fail unless closing speeds come when they should, on the occasions with one of these tags.

    A node that never publishes one keeps no pace: its silence shows nothing.
    """
    for recording in runs:
        require_alive(recording)
        due = [case for _, case in runs.of([recording]).cases("full")]
        if due and not any(case.count for case in due):
            fail(
                f"not a single message came on {TOPIC}",
                expected="a closing speed from the tenth reading on",
                actual=f"nothing on {TOPIC}",
                at=due[0].at,
                recording=recording,
                help="A deque(maxlen=10) never holds more than ten: compare with == 10 or >= 10.",
            )
    for recording, case in runs.cases(*(tags or PACED)):
        wanted = 1 if case.allowed else 0
        if case.count != wanted:
            came = "1 closing speed" if case.count == 1 else f"{case.count or 'no'} closing speeds"
            said = f"{float(case.said['data']):.3f} m/s" if case.said else f"nothing on {TOPIC}"
            fail(
                f"{came} came after {case.what}",
                expected="exactly one" if wanted else f"nothing on {TOPIC}",
                actual=said,
                at=case.at,
                recording=recording,
                help=help,
            )


def says(runs: Runs, *tags: str, help: str, topic: str = CMD_VEL_TOPIC) -> None:
    """Fail unless what the node says is right, on each occasion with one of these tags.

    Unlike `follows` it asks all runs together whether the node reacts: in some of them a node
    without a trend, or with an older one, has only one thing to say.
    """
    for recording in runs:
        require_alive(recording)
    for recording, case in runs.cases(*tags):
        require_allowed(recording, case, slip(case) or help, topic=topic)
    kind = "command" if topic == CMD_VEL_TOPIC else "full"
    reacts(runs[0], [case for _, case in runs.cases(kind)])


def slip(case: Case) -> str:
    """Say so if only the sign of a closing speed is wrong, or digits are missing."""
    said = case.said.get("data")
    if not isinstance(said, float) or case.wrong(TOLERANCE) != "data":
        return ""
    opposite = replace(case, said={"data": -said})
    if abs(said) > TOLERANCE and not opposite.wrong(TOLERANCE):
        return "Only the sign is wrong: it is *minus* the slope, positive for what comes closer."
    right = [float(bounds[0]) for bounds in case.allowed["data"]]
    if any(said == round(least, digits) for least in right for digits in range(3)):
        return "The number is right, and rounded: publish it as it is, and round in the log only."
    return ""
