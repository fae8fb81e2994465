"""Make the data of the lesson's figures to play with: scans of four lidars, and a forest.

`python -m grader.authoring.play_data` writes lessons/_static/play/data.js; `--check` tells whether
it is up to date.
"""

import json
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from grader.course.exercises import ROOT
from grader.course.generated import write_or_check
from sim.caster import Caster, static_faces
from sim.layout import Floats
from sim.lidar import PROFILES, readings
from sim.placement import scenario_layout
from sim.scenario_files import load_scenario

FILE = ROOT / "lessons" / "_static" / "play" / "data.js"
SCENARIO = "demo_store"
POSE = (0.0, -1.6, 0.3)  # [m, m, rad] in it, with a box ahead and a pillar beside
LIDARS = {  # name: profile, and how it is mounted [rad]
    "default": ("default", 0.0),
    "LDS-01": ("lds01", 0.0),
    "wide": ("wide", 0.0),
    "default, mounted turned": ("default", -math.pi / 2),
}
TREES, ROWS = 20, 500  # of the forest of models.md
STEPS = 400  # at which it is tabulated


def scan(profile: str, mounted: float) -> Floats:
    """Return what a lidar reads in the store, (beams,) [m]."""
    lidar, scenario = PROFILES[profile], load_scenario(SCENARIO)
    caster = Caster(
        static_faces(scenario_layout(scenario, scenario.seed)),
        beams=lidar.beams,
        per_turn=lidar.per_turn,
        angle_min=lidar.angle_min,
        range_max=lidar.range_max,
    )
    x, y, yaw = POSE
    return readings(caster.cast(x, y, yaw + mounted), lidar).astype(np.float64)


def lidars() -> Iterator[dict[str, Any]]:
    """Yield each lidar with its scan; a reading of infinity is null."""
    for name, (profile, mounted) in LIDARS.items():
        lidar = PROFILES[profile]
        seen = [round(r, 3) if math.isfinite(r) else None for r in scan(profile, mounted).tolist()]
        yield {
            "name": name, "angle_min": lidar.angle_min, "angle_increment": lidar.angle_increment,
            "range_min": lidar.range_min, "range_max": lidar.range_max, "mounted": mounted,
            "ranges": seen,
        }  # fmt: skip


def learned() -> tuple[Any, Any]:
    """Return the forest and the line of models.md, trained as there."""
    from sklearn.ensemble import RandomForestRegressor  # noqa: PLC0415  (1 s)
    from sklearn.linear_model import LinearRegression  # noqa: PLC0415

    distance = np.random.default_rng(7).uniform(0.3, 1.0, ROWS)
    speed = np.minimum(0.5, np.sqrt(2 * 0.9 * (distance - 0.3)))
    rows = distance.reshape(-1, 1)
    forest = RandomForestRegressor(n_estimators=TREES, random_state=0).fit(rows, speed)
    return forest, LinearRegression().fit(rows, speed)


def models() -> dict[str, Any]:
    """Return what the forest says at even distances from 0 to 1.2 m, and the line's law."""
    forest, line = learned()
    at = np.linspace(0.0, 1.2, STEPS + 1)
    return {
        "step": 1.2 / STEPS,
        "forest": [round(v, 4) for v in forest.predict(at.reshape(-1, 1)).tolist()],
        "slope": round(float(line.coef_[0]), 6),
        "intercept": round(float(line.intercept_), 6),
    }


def latencies() -> list[float]:
    """Return a hundred latencies of a model that is usually quick [ms], as in real_time.md."""
    return [round(v, 1) for v in np.random.default_rng(3).normal(18.0, 2.0, 100).tolist()]


def made() -> Iterator[tuple[Path, str]]:
    """Yield the file and its text."""
    data = {"lidars": list(lidars()), "models": models(), "latencies": latencies()}
    text = json.dumps(data, separators=(",", ":"))
    yield FILE, f"// Made by `python -m grader.authoring.play_data`.\nwindow.playData = {text};\n"


if __name__ == "__main__":
    command = "python -m grader.authoring.play_data"
    sys.exit(write_or_check(made(), command, sys.argv[1:]))
