"""Ramps, distances and repeats, files that are several scenarios, and what a bench need not say."""

from pathlib import Path

import pytest
from simulated import refusal

from sim.scenario_files import load_scenario, scenario_from_toml, scenario_names

TWO = "expected two distances, [5.0, 0.4]"
COUNT, EVERY = "expected a count from 1 to 20000", "expected seconds from turn to turn"
WRITTEN = 'expected distances as the labels write them, ["0.30", "5"]'
BENCH = 'title = "x"\nduration = 1.0\nbench = [{}]\n'


def test_a_ramp_is_a_scan_for_each_step() -> None:
    scenario = scenario_from_toml(BENCH.format("{ ramp = [1.0, 0.4], scans = 4 }"), "mine.toml")
    assert [scan.fill for scan in scenario.bench] == [1.0, 0.8, 0.6, 0.4]
    assert [scan.label for scan in scenario.bench] == ["1.0 m", "0.8 m", "0.6 m", "0.4 m"]


def test_a_ramp_in_patches_has_its_words_and_its_fill() -> None:
    ramp = '{ ramp = [2.0, 1.0], scans = 2, label = "{} ahead", fill = 5.0, tags = ["near"], '
    ramp += "patches = [{ from_deg = -5, to_deg = 5 }] }"
    first, second = scenario_from_toml(BENCH.format(ramp), "mine.toml").bench
    assert (first.label, first.fill, first.tags) == ("2.0 m ahead", 5.0, ("near",))
    assert [scan.patches[0].range for scan in (first, second)] == [2.0, 1.0]


def test_each_distance_is_a_scan_labelled_as_it_is_written() -> None:
    each = '{ each = ["0.30", "5"], label = "{} ahead", fill = 9.0, tags = ["near"], '
    each += "patches = [{ from_deg = -5, to_deg = 5 }] }, "
    first, second, last = scenario_from_toml(
        BENCH.format(each + '{ each = ["1.20"], repeat = 9 }'), "mine.toml"
    ).bench
    assert (first.label, first.fill, first.tags) == ("0.30 m ahead", 9.0, ("near",))
    assert [scan.patches[0].range for scan in (first, second)] == [0.3, 5.0]
    assert (second.label, last.label, last.fill, last.repeat) == ("5 m ahead", "1.20 m", 1.2, 9)


def test_scans_in_turn_are_repeated_together() -> None:
    turn = "{ repeat = 2, of = [{ fill = 1.0 }, { ramp = [0.4, 0.3], scans = 2 }] }"
    bench = scenario_from_toml(BENCH.format(turn), "mine.toml").bench
    assert [scan.fill for scan in bench] == [1.0, 0.4, 0.3, 1.0, 0.4, 0.3]


SCRIPT = 'title = "x"\nworld = "open"\nscript = [{}]\n'


@pytest.mark.parametrize(
    ("entries", "times"),
    [
        ("{ at = 1.0, e_stop = true, repeat = 3, every = 0.1 }", [1.0, 1.1, 1.2]),
        (
            "{ repeat = 2, every = 0.5, of = [{ at = 1.0, e_stop = true }, "
            "{ at = 1.05, e_stop = false }] }",
            [1.0, 1.05, 1.5, 1.55],
        ),
    ],
)
def test_events_are_repeated_later(entries: str, times: list[float]) -> None:
    script = scenario_from_toml(SCRIPT.format(entries), "mine.toml").script
    assert [event.at for event in script] == times


@pytest.mark.parametrize(
    ("text", "entry", "said"),
    [
        (BENCH, "{ ramp = [1.0, 0.4] }", "bench.0: scans = null: expected at least 2 for a ramp"),
        (BENCH, "{ ramp = [1.0], scans = 3 }", f"bench.0: ramp = [1.0]: {TWO}"),
        (BENCH, "{ each = [1.0] }", f"bench.0: each = [1.0]: {WRITTEN}"),
        (BENCH, "{ each = [] }", f"bench.0: each = []: {WRITTEN}"),
        (BENCH, '{ each = ["1 m"] }', f'bench.0: each = ["1 m"]: {WRITTEN}'),
        (BENCH, "{ of = [{}] }", f"bench.0: repeat = null: {COUNT}"),
        (BENCH, "{ repeat = 2, of = 3 }", "bench.0: of = 3: expected a list"),
        (BENCH, "{ repeat = 2, of = [], fill = 1.0 }", "bench.0: unknown key 'fill' beside 'of'"),
        (SCRIPT, "{ at = 1.0, repeat = 0, every = 1.0 }", f"script.0: repeat = 0: {COUNT}"),
        (SCRIPT, "{ at = 1.0, repeat = 2 }", f"script.0: every = null: {EVERY}"),
    ],
)
def test_a_ramp_or_a_repeat_that_is_none_is_named(text: str, entry: str, said: str) -> None:
    refused = refusal(scenario_from_toml, text.format(entry), "mine.toml")
    assert refused == f"mine.toml: {said}"


def test_a_bench_stands_in_an_empty_world_without_odometry() -> None:
    scenario = scenario_from_toml(BENCH.format("{ fill = 1.0 }"), "mine.toml")
    assert not scenario.odometry.enabled
    assert scenario.world.description == "Nothing: the bench says what the lidar sees."
    other = BENCH.format("{ fill = 1.0 }") + '[world]\ndescription = "A hall"\n'
    assert scenario_from_toml(other, "mine.toml").world.description == "A hall"


CELLS = """
title = "Near"
duration = 1.0
seed = 1
bench = [{ fill = 1.0 }]

[matrix.onnx]
title = "From ONNX"

[matrix.later]
title = "Later"
seed = 2
"""


def test_a_matrix_is_a_scenario_for_each_cell(course: Path) -> None:
    (course / "near.toml").write_text(CELLS)
    assert list(scenario_names()) == ["near_later", "near_onnx"]
    onnx, later = load_scenario("near_onnx"), load_scenario("near_later")
    assert (onnx.name, onnx.title, onnx.seed) == ("near_onnx", "From ONNX", 1)
    assert (later.name, later.title, later.seed) == ("near_later", "Later", 2)
    (course / "mine.toml").write_text('title = "Mine"\nextends = "near_later"\n')
    assert (load_scenario("mine").seed, load_scenario("mine").title) == (2, "Mine")


def test_the_file_of_a_matrix_is_none_itself(course: Path) -> None:
    (course / "near.toml").write_text(CELLS)
    assert "near" in refusal(load_scenario, "near")
    said = refusal(load_scenario, course / "near.toml")
    assert "several scenarios (near_onnx, near_later)" in said


def test_an_empty_matrix_is_named(course: Path) -> None:
    (course / "near.toml").write_text(CELLS.partition("[matrix")[0] + "[matrix]\n")
    said = "matrix: expected at least one cell, such as [matrix.onnx]"
    assert refusal(scenario_names) == f"{course / 'near.toml'}: {said}"


def test_two_cells_of_one_name_are_refused(course: Path) -> None:
    (course / "near.toml").write_text(CELLS)
    (course / "near_onnx.toml").write_text(CELLS.partition("[matrix")[0])
    assert "two scenarios are called 'near_onnx'" in refusal(scenario_names)
    (course / "near_onnx.toml").unlink()
    (course / "near.toml").write_text(CELLS + "[matrix.onnx]\nseed = 3\n")
    assert "near.toml: " in refusal(scenario_names)
