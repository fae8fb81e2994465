"""The drive's limits, and what happens when the robot meets something."""

import math

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.robot import COLLISION_SLOP
from sim.scenario import ROBOTS, RobotSpec
from sim.scenario_files import scenario_from_toml
from sim.simulation import Simulation

SETTINGS = settings(derandomize=True, deadline=None, max_examples=15)
QUIET = "[lidar]\nenabled = false\n[odometry]\nenabled = false\n"
SECOND = 10**9


def drive(text, commands, seconds, world='world = "hall"'):
    """Return the truth of a run without sensors, in which commands (time [s], v, w) are given."""
    scenario = scenario_from_toml(f'title = "x"\nduration = 60\n{world}\n{QUIET}{text}', "x")
    simulation = Simulation(scenario)
    simulation.advance(round(seconds * SECOND), [(round(t * SECOND), v, w) for t, v, w in commands])
    return simulation.truth()


def held(begin, end, v, w=0.0):
    """Return the command once every 0.1 s."""
    return [(begin + 0.1 * k, v, w) for k in range(round((end - begin) * 10))]


@pytest.mark.parametrize(
    ("spec", "fastest", "gains"),
    [
        ("", (0.5, -1.9), (0.9, 7.0)),
        ("max_linear = 0.2\nmax_angular = 0.5", (0.2, -0.5), (0.9, 7.0)),
        ('name = "turtlebot3_burger"', (0.22, -2.84), (2.5, 3.2)),
    ],
)
def test_a_robot_obeys_its_limits(spec, fastest, gains):
    text = f"[robot]\nstart = [-5, 0, 0]\n{spec}"
    truth = drive(text, held(0, 5, 9.0, -9.0), 5, 'world = "open"')
    assert (truth.v.max(), truth.w.min()) == pytest.approx(fastest)
    changes = (np.abs(np.diff(each)).max() / 0.02 for each in (truth.v, truth.w))
    assert tuple(changes) == pytest.approx(gains)


@pytest.mark.parametrize("name", ROBOTS)
def test_every_robot_is_one_and_may_be_changed(name):
    text = f'title = "x"\nworld = "open"\n[robot]\nname = "{name}"\nmax_linear = 0.1'
    robot = scenario_from_toml(text, "x").robot
    assert robot == msgspec.structs.replace(RobotSpec(**ROBOTS[name]), max_linear=0.1)


def test_it_drives_a_circle_of_radius_v_over_w():
    truth = drive("", held(0, 30, 0.2, 0.5), 30, 'world = "open"')
    late = truth.t > 5 * SECOND
    x, y = truth.x[late], truth.y[late]
    middle = np.array([x.min() + x.max(), y.min() + y.max()]) / 2
    radii = np.hypot(x - middle[0], y - middle[1])
    assert radii == pytest.approx(np.full(len(radii), 0.4), abs=1e-3)
    moved = np.arctan2(np.diff(y), np.diff(x))  # along its mean heading
    assert np.abs(np.sin(moved - truth.yaw[late][:-1] - 0.01 * 0.5)).max() < 1e-6
    assert np.abs(truth.yaw).max() <= math.pi


def test_it_stops_half_a_second_after_the_last_command():
    truth = drive("", held(0, 2, 0.45), 4, 'world = "open"')
    last = 1.9
    assert truth.v[truth.t <= round((last + 0.5) * SECOND)][-1] == pytest.approx(0.45)
    assert truth.v[truth.t >= round((last + 0.5 + 0.45 / 0.9 + 0.03) * SECOND)].max() < 1e-9


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_command_that_is_not_finite_stops_it(bad):
    for broken in ((bad, 0.0), (0.3, bad)):
        commands = [*held(0, 1, 0.3), *((t, *broken) for t, _, _ in held(1, 2, 0.0))]
        truth = drive("", commands, 2, 'world = "open"')
        assert truth.v[-1] == 0.0
        assert truth.w[-1] == 0.0


@SETTINGS
@given(st.floats(-180, 180), st.floats(0.1, 2.0), st.integers(20, 5000))
def test_it_never_gets_through_a_wall(degrees, speed, slice_ms):
    """Also in slices as coarse as you like, at the greatest speed a scenario allows."""
    text = f"[robot]\nstart = [0, 0, {degrees}]\nmax_linear = 2\nmax_acceleration = 20"
    scenario = scenario_from_toml(f'title = "x"\nworld = "hall"\n{QUIET}{text}', "x")
    simulation = Simulation(scenario)
    commands = [(round(t * SECOND), speed, 0.0) for t, _, _ in held(0, 15, speed)]
    while simulation.now < 15 * SECOND:
        simulation.advance(simulation.now + slice_ms * 1_000_000, commands)
        commands = []
    truth = simulation.truth()
    assert np.abs(truth.x).max() < 6 - 0.17 + 0.02
    assert np.abs(truth.y).max() < 4 - 0.17 + 0.02


def test_it_stops_at_a_wall_touching_it_and_can_back_away():
    commands = [*held(0, 6, 0.5), *held(6, 9, -0.3)]
    truth = drive("[robot]\nstart = [4.5, 0, 0]", commands, 10)
    pushing = (truth.t > 5 * SECOND) & (truth.t < 6 * SECOND)
    assert truth.x[pushing] == pytest.approx(6 - 0.17 + COLLISION_SLOP, abs=1e-3)
    assert np.abs(truth.v[pushing]).max() < 1e-6
    assert truth.contact[pushing].all()
    assert not truth.clearance[pushing].any()
    away = truth.t > 6.5 * SECOND
    assert not truth.contact[away].any()
    assert truth.v[away].min() == pytest.approx(-0.3)
    assert truth.x[-1] == pytest.approx(5.831 - 0.3 * 3.4, abs=0.01)
    assert truth.clearance[-1] == pytest.approx(6 - 0.17 - truth.x[-1], abs=1e-9)


@pytest.mark.parametrize("gap", [0.0001, 0.001, 0.01])
def test_standing_turning_and_driving_along_a_wall_is_no_contact(gap):
    start = f"[robot]\nstart = [{6 - 0.17 - gap}, 0, 90]"
    for commands in ([], held(0, 3, 0.0, 1.9), held(0, 3, 0.5)):
        truth = drive(start, commands, 3)
        assert not truth.contact.any()
        assert truth.clearance.min() == pytest.approx(gap, abs=1e-6)


def test_it_runs_into_every_kind_of_thing():
    world = "[world]\n[[world.{}]]\ncenter = [2, 0]\n{}"
    for kind, shape in [("boxes", "size = [0.4, 0.4]\nyaw_deg = 30"), ("pillars", "radius = 0.2")]:
        truth = drive("", held(0, 8, 0.5), 8, world.format(kind, shape))
        assert truth.contact.any()
        assert truth.x[truth.t < 4 * SECOND].max() < 1.75
        assert truth.clearance[truth.contact].max() == 0.0


def test_a_cart_pushes_the_robot():
    cart = "[world]\n[[world.carts]]\nsize = [0.5, 0.5]\npath = [[0, 2, 0], [4, -2, 0]]"
    truth = drive("", [], 6, cart)
    first = truth.t[truth.contact][0] / 1e9
    assert first == pytest.approx(2 - 0.25 - 0.17, abs=0.03)
    assert truth.x[-1] < -2.25
    assert truth.clearance[0] == pytest.approx(2 - 0.25 - 0.17)


def test_a_cart_that_passes_by_is_no_contact():
    cart = "[world]\n[[world.carts]]\nsize = [0.5, 0.5]\npath = [[0, 2, 1], [4, -2, 1]]"
    truth = drive("", [], 6, cart)
    assert not truth.contact.any()
    assert truth.clearance.min() == pytest.approx(1 - 0.25 - 0.17, abs=1e-3)
    assert not truth.x.any()
