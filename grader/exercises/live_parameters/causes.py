"""What the answers to orders show, for exercise 10: who answers, and what lies behind a no."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from grader.checks.parameters import orders
from grader.checks.verdict import Evidence, Trials
from grader.exercises.live_parameters.contract import RANGES
from grader.recording import Recording
from grader.recording.hands import SETTER

LETS_ALL_IN = ("declared", "refused", "all_or_none", "limits_hold")
LETS_NONE_IN = ("takes_effect", "refused", "pairs", "all_or_none")
REASONS = {  # of a refusal: what lies behind it
    "valid step": "the range's step refuses a value that lies in the range: “{}”. Leave step out: "
    "0.0 allows all values between the two.",
    "returned an invalid type": "a change is refused because the function that is asked about it "
    "returns no SetParametersResult. It returns one on every path, with successful=True where all "
    "is well.",
}
IGNORED = (
    "{} has a range of another type than its own, such as an integer_range of a double, which ROS "
    "ignores: nothing is refused by it. A double takes "
    "floating_point_range=[FloatingPointRange(from_value=…, to_value=…)]."
)
SILENT = 'in {} “{}” is refused without a reason: SetParametersResult(successful=False, reason="…")'
ASTRAY = "no node is called /{}, so nobody answers what is asked of it. There is {}: is it renamed?"
ABSENT = "the node declares no {}. What it declares: {}."


def seen(trials: Trials, failed: Sequence[str]) -> Evidence | None:
    """Return what names, rclpy or the descriptors say, where checks failed that it explains."""
    for text, names in (each for run in trials.values() for each in _said(run)):
        if explained := [check for check in failed if not names or check in names]:
            return Evidence(text, explains=explained)
    return None


def _said(run: Recording) -> Iterator[tuple[str, Sequence[str]]]:
    """Yield what a run shows, and the checks that it explains; () for all."""
    asked = [each.arguments[0] for each in run.scenario.program if each.file == SETTER]
    nodes = sorted({end.node for end in run.ends})
    if nodes and asked and f"/{asked[0]}" not in nodes:
        yield ASTRAY.format(asked[0], " and ".join(nodes)), ()
    for order, answer in ((each, each.answer) for each in orders(run) if each.answer):
        if absent := [name for name in RANGES if answer.there and name not in answer.there]:
            there = (name for name in answer.there if name != "use_sim_time")
            yield ABSENT.format(" and no ".join(absent), ", ".join(there)[:200]), ()
        ignored = [IGNORED.format(d.name[:40]) for d in answer.described if d.ignored]
        yield from ((text, LETS_ALL_IN) for text in ignored)
        for part, text in REASONS.items():
            if part in answer.reason:
                yield f"in {run.name} {text.format(answer.reason[:120])}", LETS_NONE_IN
        if answer.accepted is False and not answer.reason.strip():
            yield SILENT.format(run.name, order.text), LETS_NONE_IN
