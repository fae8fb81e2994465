"""Models that brake in good time, for drives of the exercises that have a model."""

from __future__ import annotations

import numpy as np

from grader.models.features import scan_features
from grader.models.files import probe
from grader.recording import Scan
from sim.scenario import Model, NodeSpec, Scenario

PICKLE = "velocity_model.pkl"
SCALE, OFFSET = 0.5, -0.35  # of the distance [m]: 0 at 0.7 m, 0.5 m/s at 1.7 m
MOVING = 0.1  # [m/s] what asks for less may stand

LINEAR = Model(probe="linear", settings={"weights": (SCALE, 0.0, 0.0, 0.0, 0.0), "offset": OFFSET})


def braking(probe: str, **settings: float) -> NodeSpec:
    """Return what a node finds: a pickled probe that brakes."""
    settings = {"scale": SCALE, "offset": OFFSET, **settings}
    return NodeSpec(models={PICKLE: Model(probe=probe, settings={**settings})})


def model_says_go(scenario: Scenario, scan: Scan) -> bool:
    """Return whether the scenario's model asks to drive on."""
    row = scan_features(scan)
    if not np.isfinite(row).all():
        return False
    (model,) = scenario.node.models.values()
    return bool(probe(model).predict(row[None])[0] >= MOVING)
