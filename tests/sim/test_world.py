import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.clearance import clearance, is_inside
from sim.layout import Cart, Layout, layout_from_json, layout_to_json
from sim.placement import build_layout, place
from sim.world import Box, Clutter, MovingCart, Pillar, Wall, World, load_world

SETTINGS = settings(derandomize=True, deadline=None, max_examples=60)
TRIAL_LOCK = World(
    walls=(Wall(((-3, -3), (6, -3), (6, 3))),),
    boxes=(Box((2, 1), (0.5, 1.0), 30.0),),
    pillars=(Pillar((0, 2), 0.2),),
    clutter=(Clutter(((1, -2), (5, 2)), 15, keep_clear=((3, 0, 0.5),)),),
    carts=(MovingCart((0.6, 0.4), ((0, 3, -3), (6, 3, 3))),),
)
SQUARE = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])


def crowd(seed=1, **options):
    return build_layout(TRIAL_LOCK, rng=np.random.default_rng(seed), **options)


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


def test_mirroring_then_rotating_a_pose():
    assert place((1.0, 2.0, 0.5), mirror=True) == pytest.approx((1.0, -2.0, -0.5))
    assert place((1.0, 2.0, 0.5), rotate_deg=90) == pytest.approx((-2.0, 1.0, 0.5 + math.pi / 2))
    assert place((1.0, 2.0, 0.0), mirror=True, rotate_deg=90) == pytest.approx((2, 1, math.pi / 2))


def test_quarter_turns_are_exact_and_a_plain_world_is_left_alone():
    assert place((6.0, 4.0, 0.0), rotate_deg=180)[:2] == (-6.0, -4.0)
    assert place((1.0, 2.0, 9.0)) == (1.0, 2.0, 9.0)
    hall = build_layout(load_world("hall"), rotate_deg=-90)
    assert set(hall.walls[0].ravel()) == {-6.0, 6.0, -4.0, 4.0}


def test_poses_that_are_not_finite_stay():
    x, y, yaw = place((math.nan, math.inf, 1.0), mirror=True, rotate_deg=45)
    assert math.isnan(x)
    assert (y, yaw) == (math.inf, 1.0)


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


def test_the_seed_throws_the_clutter():
    assert layout_to_json(crowd(1)) == layout_to_json(crowd(1))
    assert layout_to_json(crowd(1)) != layout_to_json(crowd(2))


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
    cart = build_layout(TRIAL_LOCK).carts[0]
    poses = cart.poses(np.array([-1.0, 0.0, 3.0, 6.0, 60.0]))
    assert poses[:, 0].tolist() == [3.0] * 5
    assert poses[:, 1].tolist() == [-3.0, -3.0, 0.0, 3.0, 3.0]
    assert poses[:, 2] == pytest.approx([math.pi / 2] * 5)
    assert cart.corners(np.array([3.0]))[0].mean(axis=0) == pytest.approx([3.0, 0.0])
    assert np.ptp(cart.corners(np.array([3.0]))[0], axis=0) == pytest.approx([0.4, 0.6])


@pytest.mark.parametrize("loop", [False, True])
def test_one_pose_of_a_cart_is_the_same_as_one_of_many(loop):
    path = np.array([[0.3, 0.1, 0.7], [1.7, 1.3, 0.2], [2.2, 1.3, 0.2], [4.1, 0.1, 0.7]])
    cart = Cart(SQUARE, path, loop=loop)
    times = np.concatenate((np.arange(0.0, 12.0, 0.01), path[:, 0]))
    assert [cart.pose(t) for t in times.tolist()] == [tuple(p) for p in cart.poses(times).tolist()]


def test_a_cart_in_a_loop_goes_on_and_keeps_its_heading_while_it_halts():
    path = np.array([[1, 0, 0], [2, 1, 0], [3, 1, 0], [4, 0, 0]], float)
    cart = Cart(SQUARE, path, loop=True)
    assert cart.pose(0.0) == (0.0, 0.0, 0.0)
    assert cart.pose(1.5) == (0.5, 0.0, 0.0)
    assert cart.pose(2.5) == (1.0, 0.0, 0.0)
    assert cart.pose(3.5) == (0.5, 0.0, math.pi)
    assert cart.pose(4.5) == cart.pose(1.5)
    assert cart.pose(31.5) == cart.pose(1.5)


def test_a_cart_with_one_way_point_is_a_box():
    cart = Cart(SQUARE, np.array([[0, 2, 1]], float))
    assert cart.pose(5.0) == (2.0, 1.0, 0.0)


def test_clearance_is_from_the_edge_capped_and_never_negative():
    layout = build_layout(World(walls=(Wall(((2, -1), (2, 1))),)))
    points = np.array([[0.0, 0.0], [1.9, 0.0], [2.0, 4.0], [-50.0, 0.0]])
    found = clearance(layout, np.zeros(4), points, 0.2)
    assert found == pytest.approx([1.8, 0.0, 2.8, 10.0])


def test_clearance_follows_a_cart():
    world = World(carts=(MovingCart((1.0, 1.0), ((0, 5, 0), (4, 1, 0))),))
    layout = build_layout(world)
    found = clearance(layout, np.array([0.0, 2.0, 4.0]), np.zeros((3, 2)), 0.2)
    assert found == pytest.approx([4.3, 2.3, 0.3])
