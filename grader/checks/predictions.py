"""A node that drives as a model says: what the model predicts, and what the node asked it.

A scan, its features, the clipped prediction. Beams within 1° of a sector's edge may count on either
side of it, so a scan has several possible feature vectors, and what is right is an interval of
speeds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import PurePath
from typing import Any

import numpy as np

from grader.checks.case import Case, Interval, among, answered, exactly
from grader.checks.commands import answers
from grader.models.features import Floats, possible_features, scan_features
from grader.models.files import is_kept, probe
from grader.recording import Inference, Recording, Scan
from sim.scenario import Model, NodeSpec, Scenario

MODEL = "velocity_model.pkl"
MAX_SPEED = 0.5  # [m/s] without the parameter
TOLERANCE = 5e-5  # [m/s] of a prediction
BROKEN = ("garbage", "empty", "pickled", "foreign")  # in files that hold no model of their format
SPEED, PREDICT = "linear.x", "predict"
CALLED = "called"  # about this scan
OTHERWISE = f"{CALLED} with other features"

# models that brake in good time, for drives
SCALE, OFFSET = 0.5, -0.35  # of the distance [m]: 0 at 0.7 m, 0.5 m/s at 1.7 m
MOVING = 0.1  # [m/s] what asks for less may stand
LINEAR = Model(probe="linear", settings={"weights": (SCALE, 0.0, 0.0, 0.0, 0.0), "offset": OFFSET})


def model_file(scenario: Scenario) -> str:
    """Return the parameter model_path that the node was given."""
    return str(scenario.node.parameters.get("model_path", MODEL))


def model_found(scenario: Scenario) -> Model | None:
    """Return the model in the node's file; None if there is none that could be loaded."""
    model = scenario.node.models.get(str(PurePath(model_file(scenario))))
    return None if model is None or model.probe in BROKEN else model


def max_speed(scenario: Scenario) -> float:
    """Return the parameter max_speed that the node was given [m/s]."""
    return float(scenario.node.parameters.get("max_speed", MAX_SPEED))


def braking(probe: str, **settings: float) -> NodeSpec:
    """Return what a node finds: a pickled probe that brakes."""
    settings = {"scale": SCALE, "offset": OFFSET, **settings}
    return NodeSpec(models={MODEL: Model(probe=probe, settings={**settings})})


def model_says_go(scenario: Scenario, scan: Scan) -> bool:
    """Return whether the scenario's model asks to drive on."""
    (model,) = scenario.node.models.values()
    speed = _predict(probe(model), scan_features(scan), math.inf)
    return speed is not None and speed >= MOVING


def prediction(model: Any, scan: Scan, limit: float) -> tuple[Interval, ...]:
    """Return what a probe (None: no model) may predict from a scan, clipped to the limit [m/s].

    With 0.0 where there may be no prediction.
    """
    rows = () if model is None else possible_features(scan)
    speeds = [_predict(model, features, limit) for features in rows]
    numbers = [speed for speed in speeds if speed is not None]
    none = exactly(0.0) if len(numbers) < len(speeds) or not numbers else ()
    return none + (((min(numbers), max(numbers)),) if numbers else ())


def predictions(recording: Recording) -> tuple[tuple[Interval, ...], ...]:
    """Return what the scenario's model predicts from each scan sent."""
    model, limit = probe(recording.scenario.node.models[MODEL]), max_speed(recording.scenario)
    return tuple(prediction(model, scan, limit) for scan in recording.scans())


def speed_cases(recording: Recording, model: Model | None) -> list[Case]:
    """Return a case for each scan: the command is what this model (None: none) predicts.

    Of a model that the judge keeps it is known what it was asked and said: the node has to ask it
    about each scan, and to command what it said. No question is due about a scan that may count as
    blind, nor with a max_speed of 0.
    """
    found, limit = answers(recording), max_speed(recording.scenario)
    source = None if model is None else probe(model)
    kept = model is not None and is_kept(model_file(recording.scenario), model) and limit > 0.0
    ends = [*(answer.scan.t for answer in found[1:]), recording.duration_s]
    cases = []
    for answer, end in zip(found, ends, strict=False):
        right = prediction(source, answer.scan, limit)
        case = answered(answer, {SPEED: right})
        if kept and case.said and not np.isnan(possible_features(answer.scan)).any():
            case = _of_kept(case, right, questions(recording, PREDICT, answer.scan.t, end), limit)
        cases.append(case)
    return cases


def questions(recording: Recording, method: str, since: float, until: float) -> list[Inference]:
    """Return what a model was asked and had answered between two times [s].

    In real time what happened shortly before or after counts, too.
    """
    begin, end = since - recording.slack, until + recording.slack
    return [
        i
        for i in recording.inferences
        if i.method == method and begin <= i.asked / 1e9 and i.answered / 1e9 <= end
    ]


def loads(recording: Recording) -> list[Inference]:
    """Return each load of a model."""
    return [inference for inference in recording.inferences if inference.is_load]


def _of_kept(
    case: Case, right: tuple[Interval, ...], asked: Sequence[Inference], limit: float
) -> Case:
    """Return the case with what the model was asked: the right speed may be computed without it."""
    said = [_clip(s, limit) for question in asked for s in question.said if math.isfinite(s)]
    fits = {speed for speed in (0.0, *said) if among(speed, right, TOLERANCE)} if asked else set()
    called = CALLED if fits or not said else OTHERWISE
    return replace(
        case,
        allowed={SPEED: exactly(*sorted(fits)) or right, PREDICT: frozenset({CALLED})},
        said={**case.said, PREDICT: called if asked else f"not {CALLED}"},
    )


def _predict(model: Any, features: Floats, limit: float) -> float | None:
    """Return the clipped prediction [m/s] from features (5,); None: no usable one."""
    if not np.isfinite(features).all():
        return None
    try:
        speed = float(model.predict(features[None])[0])
    except Exception:  # a probe that raises does so on purpose
        return None
    return _clip(speed, limit) if math.isfinite(speed) else None


def _clip(speed: float, limit: float) -> float:
    return max(0.0, min(limit, speed))
