"""What the answers to orders show, for exercise 10: a range of another type, a step, no answer."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from grader.checks.parameters import orders
from grader.checks.verdict import Evidence, Trials

LETS_ALL_IN = ("declared", "refused", "all_or_none", "limits_hold")
LETS_NONE_IN = ("takes_effect", "refused", "pairs", "all_or_none")


def seen(trials: Trials, failed: Sequence[str]) -> Evidence | None:
    """Return what rclpy or the descriptors say, where checks failed that it explains."""
    for text, names in _found(trials):
        if explained := [check for check in failed if check in names]:
            return Evidence(text, explains=explained)
    return None


def _found(trials: Trials) -> Iterator[tuple[str, tuple[str, ...]]]:
    for run, answer in ((each, o.answer) for each in trials.values() for o in orders(each)):
        for about in answer.described if answer else ():
            if about.ignored:
                yield (
                    f"{about.name[:40]} has a range of another type than its own, such as an "
                    "integer_range of a double, which ROS ignores: nothing is refused by it. A "
                    "double takes floating_point_range=[FloatingPointRange(from_value=…, "
                    "to_value=…)].",
                    LETS_ALL_IN,
                )
        reason = answer.reason if answer else ""
        if "valid step" in reason:
            yield (
                f"in {run.name} the range's step refuses a value that lies in the range: "
                f"“{reason[:120]}”. Leave step out: 0.0 allows all values between the two.",
                LETS_NONE_IN,
            )
        if "returned an invalid type" in reason:
            yield (
                f"in {run.name} a change is refused because the function that is asked about it "
                "returns no SetParametersResult. It returns one on every path, with "
                "successful=True where all is well.",
                LETS_NONE_IN,
            )
