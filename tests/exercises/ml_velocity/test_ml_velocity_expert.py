"""Who brings a formula or a table instead of learning from `train.npz` fails in a graded class."""

import inspect
import pickle
import shutil
from dataclasses import astuple
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grader.course.exercises import find_exercise
from grader.course.installed import why_not
from grader.course.students import student_key
from grader.course.submission import Submission, find_submission
from grader.grading.grading import grade_submission
from grader.models.dataset import make_dataset
from grader.models.expert import PUBLISHED
from grader.models.features import features
from grader.models.scans import PROFILE
from rclpy_virtual_time.link.hosts import ForkServer

EXERCISE = find_exercise("ml_velocity")
KEY = student_key(b"a secret of a course", "ada", EXERCISE.slug)
LACKS = why_not(("sklearn", "skl2onnx"))
pytestmark = pytest.mark.skipif(bool(LACKS), reason=LACKS)
BRINGS = """\
import sys
from pathlib import Path
out, onnx = sys.argv[4::2]
here = Path(__file__).parent
Path(out).write_bytes((here / "brought.bin").read_bytes())
Path(onnx).write_bytes(b"not asked for here")
"""


def formula(x: Any, numbers: Any) -> Any:
    """Return what the expert's law makes of the five features."""
    import numpy as np  # noqa: PLC0415

    short, late, near, wide, a, low, far, b = numbers
    front, mean, _, left, right = np.asarray(x, dtype=float).T
    lost = 0.9 * late
    stopping = np.sqrt(lost**2 + 1.8 * np.maximum(front - short, 0.0)) - lost
    s, r = (
        np.clip((value - begin) / width, 0.0, 1.0)
        for value, begin, width in (
            (np.minimum(left, right), near, wide),
            (np.minimum(mean, 4.0), low, far),
        )
    )
    s, r = (v**2 * (3 - 2 * v) for v in (s, r))
    return np.minimum(stopping, 0.5) * (a + (1 - a) * s) * (b + (1 - b) * r)


class Formula:
    """Unpickles as a model that needs no file: its code is in the pickle."""

    def __reduce__(self) -> tuple[Any, ...]:
        numbers = repr(astuple(PUBLISHED))
        source = inspect.getsource(formula)
        model = f"type('M', (), {{'predict': lambda self, x: d['formula'](x, {numbers})}})()"
        code = f"[exec({source!r}, d), {model}][1]"
        return eval, (code, {"d": {"Any": object}})


def table() -> Any:
    """Return a forest that has learned by heart what a student's copy holds."""
    from sklearn.ensemble import RandomForestRegressor  # noqa: PLC0415  (a second, in each worker)

    data = make_dataset(2000, 82)
    degrees = np.degrees(PROFILE.angles)
    seen = features(data.ranges, degrees, PROFILE.range_min, PROFILE.range_max)
    whole = np.isfinite(seen).all(axis=1)
    return RandomForestRegressor(40, random_state=0).fit(seen[whole], data.speed[whole])


def accurate(submission: Submission, forkserver: ForkServer, key: str | None) -> bool:
    only = ("training_runs", "model_loads", "model_accuracy")
    graded = grade_submission(
        EXERCISE, submission, forkserver, file="ml_velocity_controller.py", only=only, seed=key
    )
    outcomes = {check.id: check.outcome for check in graded.checks}
    assert (outcomes["training_runs"], outcomes["model_loads"]) == ("pass", "pass"), outcomes
    return outcomes["model_accuracy"] == "pass"


@pytest.mark.long  # `make test-proof` runs it
@pytest.mark.parametrize("brought", ["formula", "table"])
def test_what_was_published_helps_at_home_alone(
    brought: str, forkserver: ForkServer, tmp_path: Path
) -> None:
    model = Formula() if brought == "formula" else table()
    shutil.copy(EXERCISE.solutions / EXERCISE.files[0], tmp_path)
    (tmp_path / EXERCISE.files[1]).write_text(BRINGS)
    (tmp_path / "brought.bin").write_bytes(pickle.dumps(model))
    submission = find_submission(tmp_path, EXERCISE.files[0], EXERCISE.files[1:])
    assert accurate(submission, forkserver, None)
    assert not accurate(submission, forkserver, KEY)


def test_who_learns_from_the_data_is_right_with_any_expert(forkserver: ForkServer) -> None:
    reference = find_submission(EXERCISE.solutions, EXERCISE.files[0], EXERCISE.files[1:])
    assert accurate(reference, forkserver, KEY)
