"""The autograder in Gradescope's folders: what it writes, and what a submission can't do to it.

The schema is written after Gradescope's "Autograder Specifications" (docs/specs.md of
gradescope/autograder_samples): its fields and no others, its words for formats and visibility.
"""

import json
import os
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from grader.classroom import autograder
from grader.classroom.autograder import SECRET, SETTINGS, composed, main, submitter
from grader.classroom.queue.work import UnitResult
from grader.classroom.row import GRADED, StoredResult
from grader.course.exercises import ROOT, find_exercise
from grader.course.students import student_key

jsonschema = pytest.importorskip("jsonschema", reason="comes with the extra `notebooks`")

FORMATS = {"enum": ["text", "html", "simple_format", "md", "ansi"]}
SEEN = {"enum": ["hidden", "after_due_date", "after_published", "visible"]}
NUMBER, TEXT = {"type": "number"}, {"type": "string"}
TEST = {
    "type": "object",
    "additionalProperties": False,
    "properties": {
        "score": NUMBER, "max_score": NUMBER, "status": {"enum": ["passed", "failed"]},
        "name": TEXT, "name_format": FORMATS, "number": TEXT, "output": TEXT,
        "output_format": FORMATS, "tags": {"type": "array", "items": TEXT},
        "visibility": SEEN, "extra_data": {"type": "object"},
    },
}  # fmt: skip
RESULTS = {
    "type": "object",
    "additionalProperties": False,
    "anyOf": [{"required": ["score"]}, {"required": ["tests"]}],
    "properties": {
        "score": NUMBER, "execution_time": NUMBER, "output": TEXT, "output_format": FORMATS,
        "test_output_format": FORMATS, "test_name_format": FORMATS, "visibility": SEEN,
        "stdout_visibility": SEEN, "extra_data": {"type": "object"},
        "tests": {"type": "array", "items": TEST}, "leaderboard": {"type": "array"},
    },
}  # fmt: skip
SLUG, FILE = "obstacle_avoidance", "obstacle_avoidance_agent.py"
LIES = """
import os
for place in ("results.json", "results.json.part", "more"):
    for folder in ("results", "source"):
        try:
            with open(os.path.join(ROOT, folder, place), "w") as file:
                file.write('{"score": 1000}')
        except OSError as error:
            print("not written:", type(error).__name__)
for name in ("course.secret", "autograder.json"):
    try:
        print("read", open(os.path.join(ROOT, "source", name)).read())
    except OSError as error:
        print("not read:", type(error).__name__)
raise SystemExit
"""
KEY = "0123456789abcdef" * 2


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """Gradescope's folders, with an autograder for exercise 1 unpacked."""
    for name in ("source", "submission", "results"):
        (tmp_path / name).mkdir()
    chosen(tmp_path, SLUG)
    return tmp_path


def chosen(place: Path, *slugs: str, secret: bool = False) -> None:
    said = {"exercises": slugs, "field": False, "hide": ["worlds"]}
    (place / "source" / SETTINGS).write_text(json.dumps(said), "utf-8")
    if secret:
        (place / "source" / SECRET).write_text(KEY, "utf-8")


def results_of(place: Path) -> dict[str, Any]:
    """Run the autograder; return what it writes."""
    assert main([str(place)]) == 0
    found: dict[str, Any] = json.loads((place / "results" / "results.json").read_text("utf-8"))
    jsonschema.validate(found, RESULTS)
    return found


def test_nothing_to_grade_is_told_with_what_is_there(place: Path) -> None:
    for name in ("mine.py", "node.py"):
        (place / "submission" / name).write_text("print('hi')")
    os.mkfifo(place / "submission" / "pipe")
    (place / "submission" / FILE).symlink_to("/etc/passwd")

    found = results_of(place)
    assert found["score"] == 0
    (test,) = found["tests"]
    assert (test["score"], test["max_score"], test["status"]) == (0, 100, "failed")
    assert "there is mine.py, node.py (links are not followed)" in test["output"]


def test_the_only_work_counts_whatever_it_is_called(place: Path) -> None:
    text = (ROOT / "solutions" / SLUG / FILE).read_text("utf-8")
    (place / "submission" / "mine.py").write_text(text.replace("rclpy.init(", "rclpy.inti("))

    found = results_of(place)
    assert found["output"].startswith("Obstacle avoidance: 0 of 100 points\n")
    assert "mine.py was graded, the only file that may be work" in found["output"]


def test_of_two_copies_the_page_names_the_one_that_counts(place: Path) -> None:
    for name in (FILE, FILE.replace(".py", " (1).py")):
        (place / "submission" / name).write_text("def main(:\n")

    found = results_of(place)
    assert "(1).py was graded; 1 more of that name did not count" in found["output"]
    assert "a syntax error: `python3 FILE` says where" in found["tests"][0]["output"]


@pytest.mark.long
def test_a_renamed_file_is_graded_and_no_seed_is_told(place: Path) -> None:
    chosen(place, SLUG, "goal_seeking", secret=True)
    (place / "submission" / "Obstacle_avoidance_agent (2).py").write_bytes(
        (ROOT / "solutions" / SLUG / FILE).read_bytes()
    )
    (place / "submission_metadata.json").write_text(
        json.dumps({"id": 1, "users": [{"id": 9, "name": "Bob"}, {"id": 5, "name": "Ann Lee"}]})
    )
    (place / "results" / "results.json").write_text("of an earlier run")

    found = results_of(place)
    assert found["score"] == 100
    assert found["output"].startswith("Obstacle avoidance: 100 of 100 points\nGoal seeking: 0 of")
    graded = [test for test in found["tests"] if test.get("extra_data")]
    assert sum(test["max_score"] for test in graded) == 100
    assert all(test["output_format"] == "text" for test in found["tests"])
    text = json.dumps(found)
    assert KEY not in text
    assert "seed" not in text
    assert student_key(KEY.encode(), "Ann Lee", SLUG) not in text
    assert [path.name for path in (place / "results").iterdir()] == ["results.json"]
    assert (place / "results").stat().st_mode & 0o77 == 0


@pytest.mark.long
def test_a_node_writes_no_results_and_reads_no_secret(place: Path) -> None:
    chosen(place, SLUG, secret=True)
    place.chmod(0o755)
    text = LIES.replace("ROOT", repr(str(place)))
    (place / "submission" / FILE).write_text(text, "utf-8")

    found = results_of(place)
    assert found["score"] == 0
    assert KEY not in json.dumps(found)
    assert sorted(path.name for path in (place / "source").iterdir()) == [SETTINGS, SECRET]


GRADED_0 = UnitResult({"score": 0, "max_score": 100, "checks": [], "file": FILE})
FAILED = UnitResult(None, "no host for the node")


@pytest.mark.parametrize(
    ("came", "layers", "none_runs", "tries", "said"),
    [
        (FAILED, {"files"}, "", 2, "no host for the node"),
        (GRADED_0, {"files"}, "no shared memory", 1, "no shared memory"),  # the container's zero
        (GRADED_0, {"limits", "calls"}, "", 0, "nothing keeps a node from the results"),
        (GRADED_0, {"files"}, "", 1, ""),
    ],
)
def test_what_is_not_the_students_is_no_score(
    place: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
    came: UnitResult, layers: set[str], none_runs: str, tries: int, said: str,
) -> None:  # fmt: skip
    (place / "submission" / FILE).write_bytes(b"print()")
    (place / "results" / "results.json").write_text("of an earlier run")
    tried = []
    monkeypatch.setattr(autograder, "grade_unit", lambda unit: tried.append(unit) or came)
    monkeypatch.setattr(autograder, "why_none_runs", lambda: none_runs)
    monkeypatch.setattr(
        autograder,
        "launcher_here",
        lambda: SimpleNamespace(guards_files=layers & {"files", "user"}),
    )

    assert main([str(place)]) == bool(said)

    assert len(tried) == tries
    assert said in capsys.readouterr().out
    there = place / "results" / "results.json"
    assert (there.exists() and "earlier" not in there.read_text()) == (not said)


def test_points_that_a_missing_library_took_are_scaled_as_in_a_class() -> None:
    core = {"kind": "core", "title": "T", "help": "", "message": ""}
    checks = [
        {**core, "id": "a", "outcome": "pass", "points": 50, "max_points": 50},
        {**core, "id": "b", "outcome": "unavailable", "points": 0, "max_points": 50},
    ]
    grading = {"score": 50, "max_score": 50, "checks": checks, "file": FILE}
    result = StoredResult("ann", SLUG, (FILE,), "", GRADED, grading, None, 0.1, 1, "", "")

    found = composed([result], [(find_exercise("goal_seeking"), "expected a file x")], [])

    assert isinstance(found, dict)
    jsonschema.validate(found, RESULTS)
    assert found["score"] == 100
    assert [test.get("score") for test in found["tests"]] == [50, None, 0]


@pytest.mark.parametrize("text", ["", "{}", '{"users": []}', '{"users": [{"id": "x"}]}', "[1]"])
def test_metadata_that_say_nothing_are_nobodys(text: str, tmp_path: Path) -> None:
    file = tmp_path / "submission_metadata.json"
    file.write_text(text)

    assert submitter(file) == "unnamed"
