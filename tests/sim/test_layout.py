"""Segments and carts of a layout, and a layout as JSON."""

import math

import numpy as np
import pytest
from simulated import CROWD, crowd

from sim.layout import Cart, layout_from_json, layout_to_json
from sim.placement import build_layout
from sim.world import Box, Wall, World

SQUARE = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
BOX = np.array([[0.5, 0.3], [-0.5, 0.3], [-0.5, -0.3], [0.5, -0.3]])


def test_a_layout_survives_json_to_the_last_bit():
    text = layout_to_json(crowd(3, rotate_deg=12.3))
    again = layout_from_json(text)
    assert layout_to_json(again) == text
    assert np.array_equal(again.segments(), crowd(3, rotate_deg=12.3).segments())
    assert again.carts[0].loop is False


def test_segments_are_those_of_walls_then_solids():
    world = World(
        walls=(Wall(((0, 0), (1, 0), (1, 1)), closed=True),), boxes=(Box((3, 3), (1, 1)),)
    )
    segments = build_layout(world).segments()
    assert segments.shape == (7, 2, 2)
    assert segments[2].tolist() == [[1, 1], [0, 0]]
    assert build_layout(World()).segments().shape == (0, 2, 2)


def test_a_cart_stands_moves_and_stands():
    cart = build_layout(CROWD).carts[0]
    poses = cart.poses(np.array([-1.0, 0.0, 3.0, 6.0, 60.0]))
    assert poses[:, 0].tolist() == [3.0] * 5
    assert poses[:, 1].tolist() == [-3.0, -3.0, 0.0, 3.0, 3.0]
    assert poses[:, 2] == pytest.approx([math.pi / 2] * 5)
    assert cart.corners(np.array([3.0]))[0].mean(axis=0) == pytest.approx([3.0, 0.0])
    assert np.ptp(cart.corners(np.array([3.0]))[0], axis=0) == pytest.approx([0.4, 0.6])


def test_a_cart_in_a_loop_goes_on_and_keeps_its_heading_while_it_halts():
    path = np.array([[1, 0, 0], [2, 1, 0], [3, 1, 0], [4, 0, 0]], float)
    cart = Cart(SQUARE, path, loop=True)
    assert cart.pose(0.0) == (0.0, 0.0, 0.0)
    assert cart.pose(1.5) == (0.5, 0.0, 0.0)
    assert cart.pose(2.5) == (1.0, 0.0, 0.0)
    assert cart.pose(3.5) == (0.5, 0.0, math.pi)
    assert cart.pose(4.5) == cart.pose(1.5)
    assert cart.pose(31.5) == cart.pose(1.5)


@pytest.mark.parametrize("loop", [False, True])
@pytest.mark.parametrize("points", [1, 2, 3, 6])
def test_one_pose_is_the_same_as_one_of_many(points: int, loop: bool) -> None:
    rng = np.random.default_rng(points)
    times = np.cumsum(rng.uniform(0.01, 3.0, points))
    path = np.column_stack((times, rng.uniform(-5.0, 5.0, (points, 2))))
    if points > 2:
        path[2, 1:] = path[1, 1:]  # a halt
    if loop:
        path[-1, 1:] = path[0, 1:]
    cart = Cart(BOX, path, loop)
    asked = np.concatenate((rng.uniform(-1.0, 20.0, 50), times, times + times[-1]))

    assert [cart.pose(float(time)) for time in asked] == list(map(tuple, cart.poses(asked)))
