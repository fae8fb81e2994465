"""What is said at full marks: what was good, and what a reader would remark without points."""

from pathlib import Path

from grader.course.exercises import SOLUTIONS, find_exercise
from grader.course.submission import find_submission
from grader.grading.grading import grade_submission
from grader.grading.praise import praise_of, remarks_on
from grader.recording import Recording
from grader.trial.trials import NodeTrials
from rclpy_virtual_time.link.hosts import ForkServer

FIRST = find_exercise("1")
NAME = FIRST.files[0]
REFERENCE = (SOLUTIONS / FIRST.slug / NAME).read_text("utf-8")


def driven(source: str, folder: Path, forkserver: ForkServer, *names: str) -> list[Recording]:
    (folder / NAME).write_text(source, "utf-8")
    with NodeTrials(find_submission(folder / NAME), forkserver) as trials:
        return [trials.get(name) for name in names]


def test_what_was_good_is_said_in_numbers(forkserver: ForkServer, tmp_path: Path) -> None:
    right = driven(REFERENCE, tmp_path, forkserver, "avoid_wall", "avoid_box_behind")
    scans = sum(len(each.delivered) for each in right)
    kept = min(each.truth.clearance.min() for each in right)
    said = praise_of(right)
    assert said.startswith(f"What was good: in 2 runs with {scans:,} messages nothing was missing")
    assert "In 2 drives the robot went 7 m" in said
    assert f"kept {kept:.2f} m from everything, or more (avoid_" in said
    assert list(remarks_on(right)) == []


def test_of_working_code_a_reader_remarks_imports_and_a_missing_stop(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    source = REFERENCE.replace("import math\n", "import math\nimport os.path as way, json\n")
    source = source.replace("        node.stop()\n", "        pass\n")
    source = source.replace("= Twist()", "= Twist(lineal=None)")
    recordings = driven(source, tmp_path, forkserver, "avoid_box_behind")
    unused, field, stop = remarks_on(recordings)
    assert unused == f"{NAME} imports way, json and never uses it."
    assert field.endswith(
        ": Twist has no field lineal, and takes the word in silence: is linear meant?"
    )
    assert "After Ctrl-C in avoid_box_behind no zero Twist came" in stop
    assert "the last command, 0.50 m/s" in stop


def test_a_turn_in_degrees_sways_and_passes(forkserver: ForkServer, tmp_path: Path) -> None:
    third = find_exercise("3")
    right = (SOLUTIONS / third.slug / third.files[0]).read_text("utf-8")
    wrong = right.replace("TURN_GAIN * heading_error(", "TURN_GAIN * 57.3 * heading_error(")
    said = []
    for source in (right, wrong):
        (tmp_path / third.files[0]).write_text(source, "utf-8")
        with NodeTrials(find_submission(tmp_path / third.files[0]), forkserver) as trials:
            driven = [trials.get(name) for name in ("goal_origin_to_5_3", "goal_turns")]
            said.append(list(remarks_on(driven)))
    assert said[0] == []  # though in goal_turns it is told other poses, and turns to both sides
    assert (
        "In goal_origin_to_5_3 the commands turned the robot from one side straight" in said[1][0]
    )


def test_praise_is_for_all_points_and_not_for_one_check(forkserver: ForkServer) -> None:
    submission = find_submission(SOLUTIONS / FIRST.slug / NAME)
    grading = grade_submission(FIRST, submission, forkserver, file=NAME, only=["wiring"])
    assert grading.full
    assert grading.notes() == []
