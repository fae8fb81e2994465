"""Scenario and world files: what they say, and that scenarios survive JSON."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.bench import BenchScan, Patch
from sim.scenario import Faults, Scenario, ScriptEvent
from sim.scenario_files import load_scenario, scenario_from_json, scenario_names, scenario_to_json
from sim.simulation import Simulation
from sim.world import World, load_world, world_names

SETTINGS = settings(derandomize=True, deadline=None, max_examples=60)
anything = st.floats(allow_nan=True, allow_infinity=True)
scans = st.builds(
    BenchScan,
    label=st.text(max_size=5),
    tags=st.lists(st.text(max_size=5), max_size=2).map(tuple),
    fill=anything,
    patches=st.lists(
        st.builds(Patch, st.floats(-180, 180), st.floats(-180, 180), anything), max_size=2
    ).map(tuple),
    repeat=st.integers(1, 5),
    empty=st.booleans(),
    stamp_offset=st.floats(-3600, 3600),
)
events = st.builds(ScriptEvent, at=st.floats(0.1, 9), goal=st.tuples(anything, anything, anything))
scenarios = st.builds(
    Scenario,
    title=st.text(max_size=9),
    world=st.sampled_from([World(), load_world("store"), load_world("hall")]),
    seed=st.integers(0, 2**53),
    faults=st.builds(Faults, range_noise=st.floats(0, 1), blackout=st.just(((1.0, 2.0),))),
    script=st.lists(events, max_size=3).map(tuple),
    bench=st.lists(scans, max_size=3).map(tuple),
)


@SETTINGS
@given(scenarios)
def test_a_scenario_survives_json(scenario):
    text = scenario_to_json(scenario)
    again = scenario_from_json(text)
    assert scenario_to_json(again) == text
    assert repr(again) == repr(scenario)


def test_every_scenario_of_the_course_runs():
    faults = {}
    for name in scenario_names():
        try:
            simulation = Simulation(load_scenario(name))
            first = simulation.next_event()
            if first is None:  # no sensor: then there are programs that talk to one another
                assert simulation.scenario.program, "no sensor and no program"
            else:
                assert simulation.advance(first) or simulation.scenario.script, "nothing happens"
        except Exception as error:
            faults[name] = error
    assert faults == {}


def test_a_scenario_is_found_by_name_path_and_text_of_a_path(tmp_path):
    path = scenario_names()["demo_wall"]
    assert load_scenario("demo_wall") == load_scenario(path) == load_scenario(str(path))


@pytest.mark.parametrize("name", world_names())
def test_every_world_says_what_it_is(name):
    assert load_world(name).description
