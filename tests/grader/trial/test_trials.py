"""The trials of one grading: how often robots are built, and what a fault of ours costs."""

import re
from pathlib import Path

import pytest
from node_runs import PREAMBLE

from grader.course import installed
from grader.course.exercises import SOLUTIONS, find_exercise
from grader.course.submission import Submission, find_submission
from grader.grading.grading import grade, grade_submission
from grader.trial import trials as trials_module
from grader.trial.progress import CHECK, TRIAL, Step
from grader.trial.seeds import trial_seed
from grader.trial.trials import NodeTrials, TrialFault
from grader.trial.virtual_time import Limits
from rclpy_virtual_time.link.hosts import ForkServer
from sim import simulation
from sim.robot import Robot
from sim.scenario_files import load_scenario

CLUTTERED = "avoid_store"  # its seed is chosen among several layouts
REFERENCE = SOLUTIONS / "obstacle_avoidance" / "obstacle_avoidance_agent.py"


@pytest.mark.parametrize("seed", [None, 7])
def test_a_graded_trial_builds_one_simulation(
    forkserver: ForkServer, monkeypatch: pytest.MonkeyPatch, seed: int | None
) -> None:
    starts: list[tuple[float, float, float]] = []  # of the robots that are put into a world

    class Noted(Robot):
        def __init__(self, spec, layout, **options) -> None:
            starts.append(layout.start)
            super().__init__(spec, layout, **options)

    monkeypatch.setattr(simulation, "Robot", Noted)
    scenario = load_scenario(CLUTTERED)
    chosen = trial_seed(scenario, seed)
    assert (chosen == scenario.seed) == (seed is None)
    assert not starts  # nor does choosing a seed build one
    with NodeTrials(Submission(REFERENCE), forkserver, seed=seed) as trials:
        recording = trials.get(CLUTTERED)

    assert (recording.outcome.completed, recording.seed) == (True, chosen)
    assert starts == [recording.layout.start]


def test_what_a_scenarios_models_are_written_with_has_to_be_installed(
    forkserver: ForkServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(installed, "_is_installed", lambda module: module != "onnx")
    lacking = "skipped: onnx is not installed here; pip install onnx"
    with NodeTrials(Submission(REFERENCE), forkserver) as trials:
        assert trials.lacks(["format_raises_torch"], ["torch", "keras"]) == lacking
        assert trials.lacks(["format_no_file", "format_late_file"], ()) == lacking
        assert trials.lacks(["format_no_file", "format_broken_onnx", "format_pt"], ()) == ""
        monkeypatch.setattr(installed, "_is_installed", lambda module: module != "sklearn")
        assert "scikit-learn" in trials.lacks(["format_drive_onnx"], ())  # it learns the tree
        assert trials.lacks(["format_onnx"], ()) == ""


# --- a fault of ours -------------------------------------------------------------------------


@pytest.fixture
def fault(monkeypatch: pytest.MonkeyPatch) -> str:
    """Make the grader fail in one scenario."""
    real = trials_module.run_trial

    def fails(submission, scenario, *rest, **options):
        if scenario.name == "avoid_zones":
            raise ZeroDivisionError("of ours")
        return real(submission, scenario, *rest, **options)

    monkeypatch.setattr(trials_module, "run_trial", fails)
    return "avoid_zones"


def test_a_fault_in_one_trial_leaves_the_others(forkserver: ForkServer, fault: str) -> None:
    with NodeTrials(Submission(REFERENCE), forkserver) as trials:
        trials.prepare([fault, "nowhere", "avoid_wall"])
        with pytest.raises(TrialFault, match=r"trial avoid_zones \(ZeroDivisionError: of ours\)"):
            trials.get(fault)
        with pytest.raises(TrialFault, match="trial nowhere"):
            trials.get("nowhere")
        assert trials.get("avoid_wall").outcome.completed
        assert [recording.name for recording in trials.recordings()] == ["avoid_wall"]
        assert {each.scenario for each in trials.faults()} == {fault, "nowhere"}


def test_the_grading_goes_on(forkserver: ForkServer, fault: str) -> None:
    exercise = find_exercise("obstacle_avoidance")
    only = ("stop_zone", "no_contact")  # the fault is in the scenario of the first
    grading = grade_submission(exercise, Submission(REFERENCE), forkserver, file="x.py", only=only)
    outcomes = {check.id: check.outcome for check in grading.checks}

    assert (outcomes["stop_zone"], outcomes["no_contact"]) == ("error", "pass")
    assert grading.score == grading.max_score > 0
    assert grading.as_dict()["provisional"]
    assert all(fault in c.message for c in grading.checks if c.outcome == "error")
    assert "ZeroDivisionError" in grading.notes()[0]


def test_what_can_not_be_saved_is_judged_all_the_same(
    forkserver: ForkServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def half(recording, place):
        place.mkdir(parents=True)
        (place / "metadata.yaml").touch()
        raise TypeError("odd")

    monkeypatch.setattr(trials_module.bag, "save", half)
    with NodeTrials(Submission(REFERENCE), forkserver, bags=tmp_path) as trials:
        recording = trials.get("avoid_wall")
        assert recording.outcome.completed
        assert not recording.bag
        (note,) = trials.notes()
    assert "avoid_wall could not be saved (TypeError)" in note
    assert not list(tmp_path.iterdir())


# --- a submission that takes its time --------------------------------------------------------


def test_a_submission_has_a_time_for_all_its_trials(
    forkserver: ForkServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    real, given = trials_module.run_trial, []

    def noted(*rest, limits, **options):
        given.append(limits)
        return real(*rest, limits=limits, **options)

    monkeypatch.setattr(trials_module, "run_trial", noted)
    monkeypatch.setattr(trials_module, "PATIENCE", 0.0)
    with NodeTrials(Submission(REFERENCE), forkserver) as trials:
        assert not trials.notes()
        assert trials.get("avoid_zones").outcome.completed
        assert trials.get("avoid_infinity").outcome.completed
        assert trials.notes() == [trials_module.SLOW]
    assert given == [Limits(), trials_module.HURRIED]
    assert trials_module.HURRIED.total < Limits().total


def test_a_submission_may_publish_so_much_in_all_its_trials(
    forkserver: ForkServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trials_module, "MUCH", 100)
    monkeypatch.setattr(trials_module, "LITTLE", 1_000)
    with NodeTrials(Submission(REFERENCE), forkserver) as trials:
        assert trials.get("avoid_zones").outcome.completed
        second = trials.get("avoid_infinity")
    assert second.outcome.kind == "flooded"
    assert sum(len(message.data) for message in second.published) < 1_000


# --- what grows, and what fails after the end ------------------------------------------------


GROWS = """
class Agent(Echo):
    def on_scan(self, scan):
        self.create_publisher(Twist, "/cmd_vel", 10).publish(Twist())
rclpy.init()
try:
    rclpy.spin(Agent())
finally:
    raise OSError("the map could not be saved")
"""


def test_a_grading_notes_what_grows_and_what_fails_after_ctrl_c(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    file = tmp_path / "obstacle_avoidance_agent.py"
    file.write_text(PREAMBLE + GROWS)
    with NodeTrials(Submission(file), forkserver) as trials:
        trials.prepare(["avoid_zones"])
        assert trials.get("avoid_zones").outcome.completed
        lost, grown, after = trials.notes()
    assert "7 messages on /cmd_vel" in lost
    assert re.search(r"In avoid_zones, .*publishers", grown)
    assert "avoid_zones" in after
    assert "the map could not be saved" in after
    assert "costs no points" in after


# --- a node that hangs or never starts -------------------------------------------------------


STARTS = "import rclpy\nfrom rclpy.node import Node\n"
NEVER_STARTS = {
    "raises": f"{STARTS}raise ValueError('no')\n",
    "returns": "pass\n",
    "never spins": f"{STARTS}import time\nrclpy.init()\nnode = Node('n')\ntime.sleep(1e6)\n",
}


@pytest.mark.parametrize("how", NEVER_STARTS)
def test_a_node_that_never_starts_is_run_for_the_checks_that_need_it_alone(
    forkserver: ForkServer, tmp_path: Path, how: str
) -> None:
    file = tmp_path / "obstacle_avoidance_agent.py"
    file.write_text(NEVER_STARTS[how])
    exercise, steps = find_exercise("obstacle_avoidance"), list[Step]()
    grading = grade_submission(
        exercise, Submission(file), forkserver, file="x.py", on_progress=steps.append
    )

    ran = {step.name for step in steps if step.what == TRIAL and not step.outcome}
    assert [check.outcome for check in grading.checks].count("skip") == len(grading.checks) - 1
    assert len(ran) <= 4  # as many as run at once
    assert [recording.name for recording in grading.recordings] == ["avoid_zones"]
    (note,) = (note for note in grading.notes() if "left out" in note)
    assert re.match(
        r"The node (ended before its first message|never spun) in the run avoid_zones, so the", note
    )


def test_a_check_that_stands_alone_is_judged_all_the_same(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    file = tmp_path / "obstacle_avoidance_agent.py"
    file.write_text("pass\n")
    with NodeTrials(Submission(file), forkserver) as trials:
        trials.prepare(["avoid_zones", "avoid_wall", "avoid_cart", "avoid_store", "avoid_infinity"])
        names = ("avoid_zones", "avoid_infinity")
        assert [trials.get(name).outcome.kind for name in names] == ["returned"] * 2
        assert [recording.name for recording in trials.recordings()] == list(names)


@pytest.mark.long
def test_progress_says_what_runs_and_what_has_passed(forkserver: ForkServer) -> None:
    exercise, steps = find_exercise("obstacle_avoidance"), list[Step]()
    grade_submission(
        exercise, Submission(REFERENCE), forkserver, file="x.py", on_progress=steps.append
    )
    begun = [step.name for step in steps if step.what == TRIAL and not step.outcome]
    ended = [step.name for step in steps if step.what == TRIAL and step.outcome == "completed"]
    assert sorted(begun) == sorted(ended)
    assert len(begun) == max(step.done for step in steps if step.what == TRIAL) > 1
    checks = [step for step in steps if step.what == CHECK]
    assert [step.done for step in checks] == list(range(1, checks[0].of + 1))
    assert checks[0].name == "wiring"
    assert {step.outcome for step in checks} == {"pass"}


def test_a_client_that_hangs_leaves_the_server_its_points(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    exercise, waits = find_exercise("model_server"), "import os; os.read(os.pipe()[0], 1)  # idle"
    for file in exercise.files:
        text = (exercise.solutions / file).read_text("utf-8")
        text = text.replace("self.request.add_done_callback(self.answer_callback)", waits)
        (tmp_path / file).write_text(text, "utf-8")
    first, *others = exercise.files
    submission = find_submission(tmp_path, first, others)
    with NodeTrials(submission, forkserver, limits=Limits(step=1.0)) as trials:
        assert trials.get("detect_slow_server").outcome.kind == "hung"
        only = ("client_wiring", "server_wiring", "answers")
        grading = grade(exercise, trials, file="x", only=only)
    outcomes = {check.id: check.outcome for check in grading.checks}
    assert outcomes["client_wiring"] == "fail"
    assert (outcomes["server_wiring"], outcomes["answers"]) == ("pass", "pass")


def test_a_node_that_is_slow_is_not_run_by_the_clock(forkserver: ForkServer) -> None:
    no_time = Limits(total=0.0)
    with NodeTrials(Submission(REFERENCE), forkserver, limits=no_time) as trials:
        recording = trials.get("avoid_wall")
        assert (recording.outcome.kind, recording.live) == ("slow", None)
        assert any("far longer than any solution's" in note for note in trials.notes())
