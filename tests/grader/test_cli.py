"""The command, as people run it: a process, its exit code, what it prints where."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import ROOT, SHORT, Done, course, course_alone

from grader.claims.mutants import find_mutant
from grader.course.exercises import SOLUTIONS, find_exercise
from grader.trial.seeds import trial_seed
from sim.scenario_files import load_scenario, scenario_names

REFERENCE = SOLUTIONS / "obstacle_avoidance" / "obstacle_avoidance_agent.py"


def complains(done: Done, *words: str) -> None:
    """One line on stderr that says these words; nothing on stdout; exit code 2."""
    assert (done.code, done.out) == (2, ""), done
    assert done.err.startswith("course: "), done.err
    assert done.err.count("\n") == 1, done.err
    for word in words:
        assert word in done.err, done.err


# --- help ----------------------------------------------------------------------------------------


def test_lists() -> None:
    assert "obstacle_avoidance_agent.py" in course("list").out
    done = course("list", "--scenarios")

    assert (done.code, done.err) == (0, "")
    listed = {line.split()[0] for line in done.out.splitlines() if line.strip()}
    assert set(scenario_names()) < listed
    assert "A wall ahead" in done.out


@pytest.mark.parametrize("command", ["list", "grade", "drive", "check-bag"])
def test_every_command_has_help_with_examples(command: str) -> None:
    done = course(command, "--help")

    assert (done.code, done.err) == (0, "")
    assert "Examples:" in done.out
    assert f"  course {command}" in done.out.split("Examples:")[1] or command == "check-bag"


def test_without_a_command_it_says_what_there_is() -> None:
    done = course_alone()

    assert (done.code, done.out) == (2, "")
    assert done.err.startswith("Usage:")


# --- wrong usage ---------------------------------------------------------------------------------


GRADE = ("grade", "obstacle_avoidance", REFERENCE)
DRIVE = ("drive", REFERENCE)
# What else is refused, and why, is said by the parts that refuse it; here, how it is printed.
WRONG: dict[str, tuple[tuple[object, ...], tuple[str, ...]]] = {
    "unknown command": (("grad",), ("No such command", "grad")),
    "too few arguments": (("grade", "1"), ("FILE|FOLDER", "--help")),
    "missing file": (("grade", "1", "@/no.py"), ("no such file", "no.py")),
    "unknown check": ((*GRADE, "--only", "stop_zoen"), ("unknown check 'stop_zoen'", "stop_zone")),
    "a seed below zero": ((*GRADE, "--seed", "-1"), ("--seed",)),
    "no folder for the report": ((*GRADE, "--report", "@/no/x.html"), ("folder does not exist",)),
    "a folder that is no bag": ((*DRIVE, *SHORT, "--bag", "@"), ("is not a bag",)),
    "missing scenario": (DRIVE, ("--scenario demo_wall", "course list --scenarios")),
    "no bag": (("check-bag", "@/no", "1"), ("expected a bag", "no")),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG)
def test_wrong_usage_takes_one_line(what: str, tmp_path: Path) -> None:
    (tmp_path / "mine").touch()
    arguments, words = WRONG[what]
    done = course(*(str(argument).replace("@", str(tmp_path)) for argument in arguments))
    complains(done, *words)


def test_a_report_that_can_not_be_written() -> None:
    complains(course(*GRADE, "--only", "wiring", "--json", "/proc/x.json"), "/proc")


def test_a_name_that_is_not_utf8(tmp_path: Path) -> None:
    name = os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9.py")
    Path(name).write_text("pass")
    complains(course_alone("drive", name, *SHORT), "caf", "ordinary characters")


def test_without_ros_it_says_how_to_get_it(tmp_path: Path) -> None:
    source = (
        "import sys, grader.cli\n"
        "from rclpy_virtual_time.link import hosts\n"
        "class NoRos(hosts.RosEnvironment):\n"
        "    find = staticmethod(lambda find=hosts.RosEnvironment.find: find({}, []))\n"
        "hosts.RosEnvironment = NoRos\n"
        f"sys.argv = ['course', 'drive', {str(REFERENCE)!r}, '--scenario', 'demo_wall']\n"
        "grader.cli.main()\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", source], capture_output=True, text=True, check=False, cwd=ROOT
    )
    complains(Done(done.returncode, done.stdout, done.stderr), "was not found", "pip install")


def test_several_near_scenarios_have_a_line_each() -> None:
    done = course(*DRIVE, "--scenario", "wall")

    first, *near = done.err.splitlines()
    assert (done.code, done.out) == (2, "")
    assert first.startswith("course: no scenario is called 'wall'; `course list --scenarios`")
    assert {"avoid_wall", "demo_wall"} <= {line.strip() for line in near}
    assert all(line.startswith("  ") and " " not in line.strip() for line in near)


# --- grade ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def graded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Done, Path]:
    """The reference of exercise 1, graded once, with everything that can be written."""
    folder = tmp_path_factory.mktemp("graded")
    done = course_alone(
        "grade", "1", REFERENCE.parent,
        "--bags", folder / "bags", "--json", folder / "result.json", "--report", folder / "r.html",
    )  # fmt: skip
    return done, folder


def verdicts(result: dict) -> dict[str, str]:  # type: ignore[type-arg]
    return {check["id"]: check["outcome"] for check in result["checks"]}


def test_the_reference_gets_full_marks(graded: tuple[Done, Path]) -> None:
    done, folder = graded
    result = json.loads((folder / "result.json").read_text("utf-8"))

    assert done.code == 0, done.err
    assert all(line.startswith("Exercise 1, ") for line in done.err.splitlines())  # how far it is
    assert "100" in done.out and "hand in obstacle_avoidance_agent.py; course next" in done.out
    assert (result["score"], result["max_score"], result["field_ready"]) == (100, 100, None)
    assert result["exercise"] == "obstacle_avoidance"
    assert set(verdicts(result).values()) == {"pass"}
    assert {"python", "rosbags", "numpy"} <= set(result["versions"])
    assert {r["outcome"] for r in result["recordings"]} == {"completed"}
    assert (folder / "r.html").read_text("utf-8").startswith("<!DOCTYPE html>")


@pytest.mark.long
def test_the_bags_give_the_same_verdicts(graded: tuple[Done, Path]) -> None:
    _, folder = graded
    result = json.loads((folder / "result.json").read_text("utf-8"))
    done = course("check-bag", folder / "bags", "obstacle_avoidance", "--json", "-")

    assert (done.code, done.err) == (0, "")
    assert done.json["checks"] == result["checks"]
    assert done.json["score"] == 100


def test_a_bag_alone_leaves_other_checks_open(graded: tuple[Done, Path]) -> None:
    _, folder = graded
    done = course("check-bag", folder / "bags" / "avoid_zones", "1", "--json", "-")

    assert done.code == 1
    assert verdicts(done.json)["ignores_behind"] == "pass"
    assert verdicts(done.json)["no_contact"] == "skip"


def test_a_bag_of_another_exercise_takes_one_line(graded: tuple[Done, Path]) -> None:
    _, folder = graded
    done = course("check-bag", folder / "bags" / "avoid_zones", "3")

    complains(done, "recorded in avoid_zones", "exercise 3")


def test_a_mutant_does_not(tmp_path: Path) -> None:
    mutant = tmp_path / "narrow_cone.py"
    mutant.write_text(find_mutant(find_exercise("obstacle_avoidance"), mutant.stem).text, "utf-8")
    done = course("grade", "obstacle_avoidance", mutant, "--only", "sees_sides", "--json", "-")

    assert (done.code, done.err) == (1, "")
    assert verdicts(done.json)["sees_sides"] == "fail"
    failed = next(c for c in done.json["checks"] if c["id"] == "sees_sides")
    assert failed["points"] == 0
    assert failed["message"]
    assert failed["expected"]


BAD_FILES = {
    "not UTF-8": (b"x = '\xff\xfe'\n", "save the file as UTF-8"),
    "raises": (b"raise RuntimeError('as I said')\n", "as I said"),
    "ends": (b"x = 1\n", "ran to its end"),
}


@pytest.mark.parametrize("what", BAD_FILES)
def test_bad_files_cost_points_and_nothing_else(what: str, tmp_path: Path) -> None:
    content, words = BAD_FILES[what]
    file = tmp_path / "agent.py"
    file.write_bytes(content)
    done = course("grade", "1", file, "--only", "wiring", "--seed", "1", "--json", "-")

    assert (done.code, done.err) == (1, "")
    assert done.json["score"] == 0
    for run in done.json["recordings"]:
        assert run["seed"] == trial_seed(load_scenario(run["scenario"]), 1)
    check = done.json["checks"][0]
    assert (check["outcome"], words in check["message"] + check["actual"]) == ("fail", True), check


def test_a_closed_pipe_is_no_crash() -> None:
    done = subprocess.run(
        f"{sys.executable} -m grader.cli list | true; exit ${{PIPESTATUS[0]}}",
        shell=True, executable="/bin/bash", cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip

    assert done.stderr == ""


def test_root_who_can_be_nobody_else_can_grade() -> None:
    """As in containers without other users: root's name, and no more than an ordinary user."""
    alone = ["unshare", "--map-root-user"]
    if shutil.which("unshare") is None or subprocess.run([*alone, "true"], check=False).returncode:
        pytest.skip("no user namespaces here")
    script = (
        "import os; from rclpy_virtual_time.host.sandbox import users;"
        "print(os.getuid(), users.is_root())"
    )
    said = subprocess.run([*alone, sys.executable, "-c", script], check=True, capture_output=True)
    assert said.stdout.split() == [b"0", b"False"]
    exercise = find_exercise("obstacle_avoidance")
    course = [sys.executable, "-m", "grader.cli", "grade", exercise.slug, "--only", "wiring"]
    done = subprocess.run(
        [*alone, *course, str(exercise.solutions / exercise.files[0])],
        check=False, capture_output=True, text=True,
    )  # fmt: skip
    assert (done.returncode, "5 / 5" in done.stdout) == (0, True), done.stdout + done.stderr


def test_a_node_that_passes_costs_no_words_for_failures() -> None:
    """What a command doesn't need, it doesn't import: each is milliseconds of every grading."""
    needless = {
        "grader.advice.deaths", "grader.advice.plain_words", "grader.classroom",
        "grader.colcon.packages", "grader.grading.causes.find", "grader.lms.platforms", "rosbags",
        "grader.nbgrader.cells", "grader.report.page", "numpy.ma",
    }  # fmt: skip
    code = f"import sys; from grader.cli import run; run(); print({needless} & {{*sys.modules}})"
    done = subprocess.run(
        [sys.executable, "-c", code, "grade", "1", REFERENCE, "--only", "callback_time"],
        check=False, capture_output=True, text=True,
    )  # fmt: skip
    assert ("15 / 15" in done.stdout, done.stdout.splitlines()[-1]) == (True, "set()"), done.stderr
