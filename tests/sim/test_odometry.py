"""Dead reckoning: without errors it is the truth, with them it drifts as told."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.events import Event
from sim.messages import ODOMETRY, decode
from sim.odometry import Odometry
from sim.placement import build_layout
from sim.scenario import OdometrySpec, Scenario
from sim.schedule import ODOM
from sim.world import World

SETTINGS = settings(derandomize=True, deadline=None, max_examples=60)
poses = st.tuples(st.floats(-9, 9), st.floats(-9, 9), st.floats(-9, 9))
START = (1.0, 2.0, 0.5)


def odometry(start=START, **spec):
    scenario = Scenario("x", World(), odometry=OdometrySpec(**spec))
    return Odometry(scenario, build_layout(World(), start=start), 1)


@SETTINGS
@given(poses, st.lists(poses, min_size=1, max_size=20))
def test_without_errors_it_reports_the_truth(start, path):
    sensor = odometry(start)
    for x, y, yaw in path:
        found = sensor.measure((x, y, yaw))
        assert found[:2] == pytest.approx((x, y), abs=1e-9)
        assert math.remainder(found[2] - yaw, math.tau) == pytest.approx(0.0, abs=1e-9)
        assert abs(found[2]) <= math.pi


def test_the_scales_are_drift():
    sensor = odometry((0.0, 0.0, 0.0), linear_scale=1.1, angular_scale=0.5)
    assert sensor.measure((1.0, 0.0, 0.0)) == pytest.approx((1.1, 0.0, 0.0))
    assert sensor.measure((1.0, 0.0, 1.0)) == pytest.approx((1.1, 0.0, 0.5))
    x, y, yaw = sensor.measure((1.0 + math.cos(1.0), math.sin(1.0), 1.0))
    assert (x, y, yaw) == pytest.approx((1.1 + 1.1 * math.cos(0.5), 1.1 * math.sin(0.5), 0.5))
    event = Event(time=1, kind=ODOM, index=0, delivery=2)
    twist = decode(sensor.message(event, (1.0, 0.0, 1.0), (1.0, 1.0)).data, ODOMETRY).twist.twist
    assert (twist.linear.x, twist.angular.z) == (1.1, 0.5)


def test_a_jump_puts_it_right():
    sensor = odometry(linear_scale=2.0)
    sensor.measure((3.0, 2.0, 0.5))
    sensor.jump((7.0, 7.0, 0.0))
    assert sensor.measure((7.0, 7.0, 0.0)) == (7.0, 7.0, 0.0)
