"""What the answers to orders show, for exercise 10: a range of another type, a step, no answer."""

from __future__ import annotations

from collections.abc import Sequence

from grader.checks.parameters import orders
from grader.checks.verdict import Evidence, Trials

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


def seen(trials: Trials, failed: Sequence[str]) -> Evidence | None:
    """Return what rclpy or the descriptors say, where checks failed that it explains."""
    for run in trials.values():
        for answer in (order.answer for order in orders(run) if order.answer):
            said = [IGNORED.format(about.name[:40]) for about in answer.described if about.ignored]
            reasons = [text for part, text in REASONS.items() if part in answer.reason]
            said += [f"in {run.name} {text.format(answer.reason[:120])}" for text in reasons]
            names = LETS_NONE_IN if answer.reason else LETS_ALL_IN
            explained = [check for check in failed if check in names]
            if said and explained:
                return Evidence(said[0], explains=explained)
    return None
