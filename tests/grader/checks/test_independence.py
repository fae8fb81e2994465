"""What the checks of several exercises share lies where each grading's fingerprint covers it."""

import pytest

from grader.classroom.queue.conditions import _sources
from grader.course.exercises import JUDGE, ROOT, Exercise, all_exercises

CHECKS = ROOT / "grader" / "checks"


@pytest.mark.parametrize("exercise", all_exercises(), ids=lambda exercise: exercise.slug)
def test_a_fingerprint_covers_the_shared_checks_and_the_exercises_own(exercise: Exercise) -> None:
    sources = set(_sources(exercise))
    own = {path for path in exercise.judge.rglob("*") if path.suffix in (".py", ".toml")}
    assert {path for path in sources if path.is_relative_to(CHECKS)} == {*CHECKS.glob("*.py")}
    assert {path for path in sources if path.is_relative_to(JUDGE)} == {*own, *JUDGE.glob("*.py")}
    used = [text for path in own if path.suffix == ".toml" for text in [path.read_text("utf-8")]]
    worlds = {path for path in (ROOT / "sim" / "worlds").glob("*.toml")
              if any(f'world = "{path.stem}"' in text for text in used)}  # fmt: skip
    assert {
        path for path in sources if path.suffix == ".toml" and path.is_relative_to(ROOT / "sim")
    } == worlds
    assert (
        ROOT / "sim" / "simulation.py" in sources
        and ROOT / "sim" / "live" / "cli.py" not in sources
    )
