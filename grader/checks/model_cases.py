"""The oracle of a node that drives as a model says: a scan, its features, the clipped prediction.

Exercises with other rules of their own (which files hold a model, at which rate) call it from
their contracts' `cases`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from grader.checks.case import Case, Interval, answered, exactly
from grader.checks.commands import Answer, answers
from grader.checks.inferences import questions
from grader.checks.predictions import Prediction, max_speed, model_file, prediction, quick
from grader.models.features import possible_features
from grader.models.files import is_kept, probe
from grader.recording import Inference, Recording
from sim.scenario import Model

SPEED, PREDICT = "linear.x", "predict"
CALLED = "called"  # about this scan


def speed_cases(recording: Recording, model: Model | None) -> list[Case]:
    """Return an occasion for each scan: the command is what this model (None: none) predicts.

    Of a model that the judge keeps it is known what it was asked and said: the node has to ask it
    about each scan, and to command what it said. No question is due about a scan that may count as
    blind, nor with a max_speed of 0.
    """
    found, limit = answers(recording), max_speed(recording.scenario)
    source = None if model is None else probe(quick(model))
    kept = model is not None and is_kept(model_file(recording.scenario), model) and limit > 0.0
    ends = [*(answer.scan.t for answer in found[1:]), recording.duration_s]
    cases = []
    for answer, end in zip(found, ends[: len(found)], strict=True):
        right = prediction(source, answer.scan, limit)
        case = answered(answer, {SPEED: right.allowed}, what=scan_in_words(recording, answer))
        if kept and case.said and not np.isnan(possible_features(answer.scan)).any():
            asked = questions(recording, PREDICT, answer.scan.t, end)
            case = replace(
                case,
                allowed={SPEED: _answered(asked, right, limit), PREDICT: frozenset({CALLED})},
                said={**case.said, PREDICT: _asked(asked, right, limit)},
            )
        cases.append(case)
    return cases


def scan_in_words(recording: Recording, answer: Answer) -> str:
    """Return which scan it is, for a student; its time if lost scans shift the bench's labels."""
    if answer.label and not recording.scenario.faults.scan_loss:
        return f"“{answer.label}”"
    return f"the scan at {answer.scan.t:.3f} s"


def _answered(asked: Sequence[Inference], right: Prediction, limit: float) -> tuple[Interval, ...]:
    """Return those of the right speeds that the model said; all of them if it said none."""
    speeds = {s for s in (*_clipped(asked, limit), *([0.0] if asked else [])) if right.allows(s)}
    return exactly(*sorted(speeds)) or right.allowed


def _asked(asked: Sequence[Inference], right: Prediction, limit: float) -> str:
    """Return what the model was asked: the right speed may have been computed without it."""
    said = _clipped(asked, limit)
    if not asked:
        return f"not {CALLED}"
    known = not said or any(map(right.allows, (0.0, *said)))
    return CALLED if known else f"{CALLED} with other features"


def _clipped(asked: Sequence[Inference], limit: float) -> list[float]:
    finite = (s for question in asked for s in question.said if math.isfinite(s))
    return [min(max(s, 0.0), limit) for s in finite]
