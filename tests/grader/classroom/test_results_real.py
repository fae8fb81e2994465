"""Results of a real class: right and wrong solutions, graded on the real rclpy, with their bags."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from marked_class import payload

from grader.authoring.mutants import find_mutant
from grader.classroom.results.options import ResultOptions
from grader.classroom.results.write import write_results
from grader.classroom.row import StoredResult
from grader.course.exercises import ROOT, find_exercise
from grader.course.submission import find_submission
from grader.grading.grading import grade_submission
from grader.grading.withheld import shows_run
from grader.link.hosts import ForkServer

pytestmark = pytest.mark.long
SUBMISSIONS = {  # the reference, or the name of a mutant
    ("ada", "obstacle_avoidance"): "obstacle_avoidance_agent.py",
    ("ben", "obstacle_avoidance"): "drives_blind",
    ("chen", "obstacle_avoidance"): "wrong_topic",
    ("dan", "obstacle_avoidance"): "keeps_the_last_speed_when_blind",
    ("ada", "goal_seeking"): "goal_seeking_agent.py",
    ("ben", "goal_seeking"): "constant_speed",
}


@pytest.fixture(scope="module")
def graded(
    forkserver: ForkServer, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, list[StoredResult]]:
    out = tmp_path_factory.mktemp("class")
    results = []
    for (student, slug), name in SUBMISSIONS.items():
        exercise = find_exercise(slug)
        file = exercise.solutions / name
        if name not in exercise.files:
            file = out / f"{name}.py"
            file.write_text(find_mutant(exercise, name).text, "utf-8")
        # replays of one are enough here, and quick
        bags = out / "recordings" / student / slug if student == "ben" else None
        grading = grade_submission(
            exercise, find_submission(file), forkserver, file=str(file), bags=bags, field=True
        )
        results.append(
            StoredResult(
                student=student,
                exercise=slug,
                file_names=exercise.files,
                input_hash="0" * 64,
                state="graded",
                grading=json.loads(json.dumps(grading.as_dict())),
                recordings=bags.relative_to(out) if bags else None,
                wall_s=1.0,
                attempts=1,
                problem="",
                finished="2026-05-04T09:12:00Z",
                canary=False,
            )
        )
    return out, results


def test_a_class_gets_its_pages_with_replays(graded: tuple[Path, list[StoredResult]]) -> None:
    out, results = graded
    written = write_results(results, out, ResultOptions(hide="field")).files
    page = payload(out / "feedback" / "ben" / "obstacle_avoidance.html")
    replays = page["replays"]
    assert isinstance(replays, list)
    assert len(replays) >= 5
    assert all(shows_run(replay["scenario"], {"field"}) for replay in replays)
    assert payload(out / "feedback" / "ada" / "obstacle_avoidance.html")["replays"] == []
    for file in written:
        assert str(ROOT) not in file.read_text("utf-8"), file


def test_hidden_worlds_are_in_no_page(graded: tuple[Path, list[StoredResult]]) -> None:
    out, results = graded
    write_results(results, out, ResultOptions(hide="details"))
    page = out / "feedback" / "ben" / "obstacle_avoidance.html"
    assert payload(page)["replays"] == []
    text = json.dumps(payload(page))
    assert "avoid_" not in text
    assert '"seed"' not in text


def test_broken_bags_cost_the_replays_only(
    graded: tuple[Path, list[StoredResult]], tmp_path: Path
) -> None:
    _, results = graded
    (tmp_path / "bags").mkdir()
    (tmp_path / "bags" / "metadata.yaml").write_text("nonsense: [")
    one = replace(results[1], recordings=Path("bags"))
    write_results([one], tmp_path)
    assert payload(tmp_path / "feedback" / "ben" / "obstacle_avoidance.html")["replays"] == []
