"""Results of a real class: a right and a wrong solution, graded on the real rclpy, with bags."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from made_results import OBSTACLES, classes
from marked_class import payload

from grader.claims.mutants import find_mutant
from grader.classroom.results.options import ResultOptions
from grader.classroom.results.write import write_results
from grader.classroom.row import StoredResult
from grader.course.exercises import ROOT, find_exercise
from grader.course.submission import find_submission
from grader.grading.grading import grade_submission
from grader.grading.withheld import shows_run
from rclpy_virtual_time.link.hosts import ForkServer

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def graded(
    forkserver: ForkServer, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, list[StoredResult]]:
    """Ada's is the reference, without bags; Ben drives blind."""
    out, exercise = tmp_path_factory.mktemp("class"), find_exercise(OBSTACLES)
    blind = out / "blind.py"
    blind.write_text(find_mutant(exercise, "drives_blind").text, "utf-8")
    bags = out / "recordings" / "ben" / OBSTACLES
    results = []
    for student, file in (("ada", exercise.solutions / exercise.files[0]), ("ben", blind)):
        grading = grade_submission(
            exercise, find_submission(file), forkserver, file=str(file), field=True,
            bags=bags if student == "ben" else None,
        )  # fmt: skip
        made = json.loads(json.dumps(grading.as_dict()))
        place = bags.relative_to(out) if student == "ben" else None
        results.append(classes.stored(student, OBSTACLES, made, recordings=place))
    return out, results


def test_a_class_gets_its_pages_with_replays(graded: tuple[Path, list[StoredResult]]) -> None:
    out, results = graded
    written = write_results(results, out, ResultOptions(hide="field")).files
    replays = payload(out / "feedback" / "ben" / f"{OBSTACLES}.html")["replays"]
    assert isinstance(replays, list)
    assert len(replays) >= 5
    assert all(shows_run(replay["scenario"], {"field"}) for replay in replays)
    assert payload(out / "feedback" / "ada" / f"{OBSTACLES}.html")["replays"] == []
    for file in written:
        assert str(ROOT) not in file.read_text("utf-8"), file


def test_broken_bags_cost_the_replays_only(
    graded: tuple[Path, list[StoredResult]], tmp_path: Path
) -> None:
    _, results = graded
    (tmp_path / "bags").mkdir()
    (tmp_path / "bags" / "metadata.yaml").write_text("nonsense: [")
    one = replace(results[1], recordings=Path("bags"))
    write_results([one], tmp_path)
    assert payload(tmp_path / "feedback" / "ben" / f"{OBSTACLES}.html")["replays"] == []
