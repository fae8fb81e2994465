"""What is odd about the commands of exercise 5: they are not what the model has said."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grader.checks.commands import spell
from grader.checks.predictions import max_speed
from grader.checks.verdict import Evidence, Trials
from grader.exercises.slow_model.contract import ROUNDED

SHARE, LEAST = 0.3, 10  # of a run's commands


def seen(trials: Trials, failed: Sequence[str]) -> Evidence | None:
    """Return that commands are between 0 and the model's words, and none of them."""
    for name, run in trials.items():
        told = [each.said[0] for each in run.inferences if not each.is_load and each.said]
        clipped = np.clip(told, 0.0, max_speed(run.scenario))
        words = np.nan_to_num([0.0, *told, *clipped])  # not to clip is a mistake of its own
        twists = run.twists()
        own = (np.abs(twists.linear_x[:, None] - words) > ROUNDED).all(axis=1)
        if told and own.sum() >= max(LEAST, SHARE * len(own)):
            first = int(np.argmax(own))
            return Evidence(
                f"{own.sum()} of {len(own)} commands of {name} are neither 0 nor what the model "
                f"said of any scan, clipped, as {spell(twists.linear_x[first])} m/s at "
                f"{twists.t[first]:.2f} s. A prediction goes out as it is until it is too old: "
                "what scales, mixes or smooths it?",
                explains=failed,
            )
    return None
