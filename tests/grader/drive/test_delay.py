"""The largest delay that a node survives, with nodes that are functions, and a real one."""

from dataclasses import replace

import pytest
from click.testing import CliRunner
from driven import careful, drive_by, reckless

from grader.authoring.delays import driving, main
from grader.checks.contract import Survived
from grader.cli import cli
from grader.course.exercises import find_exercise
from grader.drive.delay import Delays, Tried, delayed, delays
from grader.drive.delay_table import table
from grader.drive.mishaps import Mishap
from grader.errors import InputError
from grader.exercises import contract_of
from grader.recording import Outcome
from sim.scenario_files import load_scenario

FIRST = find_exercise("1")
FEW = (0, 100, 300)


def bold(scan):
    """Brake so late that no delay is left for it."""
    return 0.5 if scan.ranges.min() > 0.38 else 0.0


def of(policy, monkeypatch, worlds=("avoid_wall",), outcome=None):
    contract = replace(contract_of(FIRST), delayed_in=worlds)
    monkeypatch.setitem(delays.__globals__, "driving_contract_of", lambda exercise: contract)
    return delays(FIRST, lambda scenario: drive_by(policy, scenario, outcome), steps=FEW)


def test_a_careful_node_survives_every_delay(monkeypatch):
    result = of(careful, monkeypatch)
    assert result.survived == Survived(300, 300)
    assert [one.delay for one in result.tried["sensors"]] == list(FEW)
    margins = [one.margin for one in result.tried["commands"]]
    assert margins == sorted(margins, reverse=True)
    assert margins[-1] < margins[0]


def test_a_contract_without_scenarios_for_it_is_named(monkeypatch):
    with pytest.raises(InputError, match="names no scenarios in delayed_in"):
        of(careful, monkeypatch, worlds=())


def test_a_bold_node_survives_only_without(monkeypatch):
    result = of(bold, monkeypatch)
    assert result.survived == Survived(0, 0)
    assert "touches something (avoid_wall, " in result.tried["sensors"][1].failed


def test_a_node_that_never_brakes_or_dies_survives_nothing(monkeypatch):
    result = of(reckless, monkeypatch)
    assert result.survived == Survived(-1, -1)
    assert table(result, None)[-1] == "Survives no late commands: it fails without any delay."
    dead = of(careful, monkeypatch, outcome=Outcome("exception", "KeyError: 'x'", 1.0))
    assert dead.survived == Survived(-1, -1)
    assert "the node dies: KeyError: 'x' (avoid_wall, 1.0 s)" in dead.tried["sensors"][0].failed


def test_the_worst_world_counts(monkeypatch):
    result = of(careful, monkeypatch, worlds=("avoid_wall", "avoid_corridor"))
    alone = [of(careful, monkeypatch, worlds=(name,)) for name in ("avoid_wall", "avoid_corridor")]
    for i in range(len(FEW)):
        worst = min(one.tried["commands"][i].margin for one in alone)
        assert result.tried["commands"][i].margin == worst


def test_a_command_beyond_the_limits_is_not_what_is_asked_here(monkeypatch):
    def hasty(scan):
        return 0.6 if scan.ranges.min() > 2.0 else careful(scan)

    assert of(hasty, monkeypatch).survived == Survived(300, 300)


def test_each_drive_is_reported():
    told = []
    delays(
        FIRST,
        lambda scenario: drive_by(careful, scenario),
        steps=(0,),
        on_drive=lambda done, of: told.append((done, of)),
    )
    assert told == [(1, 4), (2, 4), (3, 4), (4, 4)]


def test_sensors_are_late_together_and_commands_alone():
    scenario = load_scenario("avoid_wall")
    faults = delayed(scenario, "sensors", 150).faults
    assert (faults.scan_latency, faults.odom_latency, faults.command_latency) == (0.15, 0.15, 0)
    assert delayed(scenario, "commands", 150).faults.command_latency == 0.15


def test_exercises_that_do_not_drive_are_refused():
    with pytest.raises(InputError, match="exercise 6: its nodes do not drive by themselves"):
        delays(find_exercise("6"), lambda scenario: drive_by(careful, scenario))


# --- what is shown -------------------------------------------------------------------------------

FAILED = Tried(300, 0.0, "avoid_cart", Mishap("dies", 1.5, "the node dies: <b>"))
RESULT = Delays(
    FIRST,
    {
        "sensors": (Tried(0, 0.3, "avoid_wall", None), FAILED),
        "commands": (Tried(0, 0.3, "avoid_wall", None), Tried(300, 0.1, "avoid_wall", None)),
    },
    "m",
)


def test_the_table_has_a_bar_for_each_delay():
    lines = table(RESULT, Survived(275, 300))
    assert "    0 ms  ####################  0.30 m  avoid_wall" in lines
    assert "  300 ms  #######               0.10 m  avoid_wall" in lines
    assert "  300 ms  the node dies: <b> (avoid_cart, 1.5 s)" in lines
    assert lines[-2:] == [
        "Survives scans and odometry that are late by 0 ms (the reference: 275 ms).",
        "Survives commands that are late by 300 ms, the most tried (the reference: 300 ms, "
        "the most tried).",
    ]


# --- the reference's numbers ---------------------------------------------------------------------


@pytest.mark.parametrize("exercise", driving(), ids=lambda exercise: exercise.slug)
def test_every_exercise_that_drives_has_worlds_and_its_references_delays(exercise):
    contract = contract_of(exercise)
    where = f"{exercise.judge / 'contract.py'}: expected"
    assert contract.delayed_in, f"{where} delayed_in=, closed loops of this exercise"
    assert [load_scenario(name).name for name in contract.delayed_in]
    command = f"python -m grader.authoring.delays {exercise.slug}"
    assert contract.survives is not None, f"{where} survives=, as `{command}` prints it"


@pytest.mark.long
def test_the_contract_has_what_the_reference_survives():
    assert main(["4"]) == 0


@pytest.mark.long
def test_a_real_node_gets_its_table():
    node = FIRST.solutions / FIRST.files[0]
    done = CliRunner().invoke(cli, ["delay", str(node)], standalone_mode=False)
    assert done.exception is None, done.output
    assert done.return_value == 0
    assert "Survives scans and odometry that are late by 300 ms" in done.stdout
