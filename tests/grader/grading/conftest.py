"""A way to run a few checks through the plug-in of pytest."""

import textwrap
from pathlib import Path

import pytest
from plugin_kit import PREAMBLE, FakeTrials, Run, count

from grader.course import exercises
from grader.course.exercises import Exercise
from grader.grading.grading import Grading, grade


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Grade with the checks in this source."""

    def run(source: str, trials: FakeTrials | None = None, **options: object) -> Grading:
        slug = f"fake_{next(count)}"  # a new name: modules of one name are imported once
        folder = tmp_path / slug
        folder.mkdir()
        (folder / "__init__.py").touch()
        (folder / f"test_{slug}.py").write_text(PREAMBLE + textwrap.dedent(source), "utf-8")
        monkeypatch.setattr(exercises, "JUDGE", tmp_path)
        exercise = Exercise(
            number=0, slug=slug, title="", summary="", files=("x.py",), node="x", max_points=100
        )
        return grade(exercise, trials or FakeTrials(), file="x.py", **options)  # type: ignore[arg-type]

    return run
