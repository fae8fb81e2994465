"""From a scenario or a world to a layout: clutter, mirroring, rotating, the robot's start."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulated import CLUTTER, INLINE, crowd, refusal

from sim.clearance import clearance, is_inside
from sim.layout import Layout
from sim.placement import build_layout, place, scenario_layout
from sim.scenario_files import scenario_from_toml
from sim.world import load_world

SETTINGS = settings(derandomize=True, deadline=None, max_examples=60)


def area(polygon):
    x, y = polygon.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


@SETTINGS
@given(st.booleans(), st.floats(-360, 360), st.integers(0, 5))
def test_solids_are_counter_clockwise_however_the_world_is_turned(mirror, degrees, seed):
    layout = crowd(seed, mirror=mirror, rotate_deg=degrees)
    assert len(layout.solids) == 17
    assert all(area(solid) > 0 for solid in layout.solids)
    assert all(area(cart.polygon) > 0 for cart in layout.carts)


@SETTINGS
@given(st.booleans(), st.floats(-360, 360), st.integers(0, 5))
def test_turning_the_world_and_the_robot_changes_no_distance(mirror, degrees, seed):
    plain, turned = crowd(seed), crowd(seed, mirror=mirror, rotate_deg=degrees)
    times = np.array([0.0, 3.0, 7.0])
    here = np.array([[0.5, 0.3], [-1.0, 1.0], [4.0, -4.0]])
    there = np.array([place((x, y, 0.0), mirror=mirror, rotate_deg=degrees)[:2] for x, y in here])
    before, after = clearance(plain, times, here, 0.1), clearance(turned, times, there, 0.1)
    assert np.allclose(before, after, atol=1e-9)


def test_quarter_turns_are_exact_and_a_plain_world_is_left_alone():
    assert place((1.0, 2.0, 0.5), mirror=True) == pytest.approx((1.0, -2.0, -0.5))
    assert place((1.0, 2.0, 0.0), mirror=True, rotate_deg=90) == pytest.approx((2, 1, math.pi / 2))
    x, y, yaw = place((math.nan, math.inf, 1.0), mirror=True, rotate_deg=45)  # these stay
    assert math.isnan(x) and (y, yaw) == (math.inf, 1.0)
    assert place((6.0, 4.0, 0.0), rotate_deg=180)[:2] == (-6.0, -4.0)
    assert place((1.0, 2.0, 9.0)) == (1.0, 2.0, 9.0)
    hall = build_layout(load_world("hall"), rotate_deg=-90)
    assert set(hall.walls[0].ravel()) == {-6.0, 6.0, -4.0, 4.0}


@SETTINGS
@given(st.integers(0, 2**32))
def test_clutter_stays_in_its_area_and_clear_of_what_is_kept_clear(seed):
    boxes = crowd(seed).solids[2:]
    assert len(boxes) == 15
    for box in boxes:
        x, y = box.mean(axis=0)
        assert 1 <= x <= 5
        assert -2 <= y <= 2
        only = Layout((), (box,), (), (0.0, 0.0, 0.0))
        assert clearance(only, np.zeros(1), np.array([[0.0, 0.0]]), 0.17)[0] >= 0.5
        assert clearance(only, np.zeros(1), np.array([[3.0, 0.0]]), 0.5)[0] >= 0.0
        assert not is_inside(only, (3.0, 0.0))


def test_jitter_moves_the_start_by_the_seed_and_within_its_limits():
    text = (
        'title = "x"\nworld = "open"\n[robot]\nstart = [1, 2, 30]\nstart_jitter = [0.5, 0.25, 10]'
    )
    scenario = scenario_from_toml(text, "x")
    starts = [scenario_layout(scenario, seed).start for seed in range(50)]
    off = np.array(starts) - (1.0, 2.0, math.radians(30))
    assert (abs(off) <= (0.5, 0.25, math.radians(10))).all()
    assert (abs(off).max(axis=0) > (0.4, 0.2, math.radians(8))).all()


@pytest.mark.parametrize("center", [[0, 0], [1.1, 0]])  # around it, touching it
def test_a_start_inside_something_is_refused(center):
    text = INLINE + f"[[world.boxes]]\ncenter = {center}\nsize = [2, 2]"
    assert refusal(scenario_layout, scenario_from_toml(text, "x"), 1) == (
        "x: robot.start: the robot would stand in something at (0, 0); "
        "expected a free place of radius 0.17"
    )


def test_clutter_that_does_not_fit_is_refused():
    text = CLUTTER + "count = 5\nkeep_clear = [[1.5, 0, 3]]"
    assert refusal(scenario_layout, scenario_from_toml(text, "x"), 1) == (
        "clutter[0]: only 0 of 5 boxes fit: make the area larger, or keep less of it clear "
        "(the robot's start is kept clear too)"
    )
