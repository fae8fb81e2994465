"""The caster against the dense computation, and where one goes wrong: corners, edges, range."""

import math

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from sim.caster import Caster, faces, static_faces
from sim.clearance import clearance, is_inside
from sim.lidar import PROFILES
from sim.placement import build_layout
from sim.world import Box, Pillar, Wall, World

SETTINGS = settings(derandomize=True, deadline=None, max_examples=40)
coordinates = st.floats(-8, 8)
points = st.tuples(coordinates, coordinates)
sizes = st.floats(0.05, 4)
worlds = st.builds(
    World,
    walls=st.lists(
        st.builds(
            lambda ends: Wall(points=ends),
            st.tuples(points, points).filter(lambda ends: math.dist(*ends) > 0.01),
        ),
        max_size=6,
    ).map(tuple),
    boxes=st.lists(
        st.builds(Box, center=points, size=st.tuples(sizes, sizes), yaw_deg=st.floats(-180, 180)),
        max_size=6,
    ).map(tuple),
    pillars=st.lists(st.builds(Pillar, center=points, radius=st.floats(0.05, 1)), max_size=4).map(
        tuple
    ),
)


def dense_ranges(segments, place, angles, range_max, reach=0.0):
    """Return, slowly, the (n,) ranges of beams at world `angles` [rad] from (x, y); inf: none.

    `reach` makes every segment longer (or shorter) at both ends, by that part of its length.
    """
    if not len(segments):
        return np.full(len(angles), np.inf)
    a, b = segments[:, 0], segments[:, 1]
    ax, ay = a[:, 0] - place[0], a[:, 1] - place[1]
    dx, dy = (b - a).T
    c, s = np.cos(angles), np.sin(angles)
    with np.errstate(all="ignore"):
        across = c[None] * dy[:, None] - s[None] * dx[:, None]
        distance = (ax * dy - ay * dx)[:, None] / across
        along = (ax[:, None] * s[None] - ay[:, None] * c[None]) / across
    # Cramer's rule for (x, y) + t (c, s) = a + u d gives t = (a × d) / (c × d) and u as above.
    hit = (distance > 0) & (along >= -reach) & (along <= 1 + reach)
    ranges = np.where(hit, distance, np.inf).min(axis=0)
    ranges[ranges > range_max] = np.inf
    return ranges


def caster_for(layout, profile):
    return Caster(
        static_faces(layout),
        beams=profile.beams,
        per_turn=profile.per_turn,
        angle_min=profile.angle_min,
        range_max=profile.range_max,
    )


def cast(world, *pose, name="default"):
    return caster_for(build_layout(world), PROFILES[name]).cast(*pose or (0.0, 0.0, 0.0))


def assert_exact(ranges, segments, place, angles, range_max):
    """Compare with the oracle; beams that just graze an end may go either way."""
    long = dense_ranges(segments, place, angles, range_max, reach=1e-9)
    short = dense_ranges(segments, place, angles, range_max, reach=-1e-9)
    with np.errstate(invalid="ignore"):
        off = [np.where(ranges == o, 0.0, abs(ranges - o)) for o in (long, short)]
    wrong = np.flatnonzero(np.minimum(*off) > 1e-9)
    near_limit = abs(np.where(np.isfinite(long), long, ranges) - range_max) < 1e-9
    assert not [i for i in wrong if not near_limit[i]]


@SETTINGS
@given(worlds, points, st.floats(-10, 10), st.sampled_from(sorted(PROFILES)))
@example(World(), (0.0, 0.0), 0.0, "default")
def test_casts_what_the_dense_oracle_casts(world, place, yaw, name):
    layout, profile = build_layout(world), PROFILES[name]
    segments = layout.segments()
    here = np.array([place])
    assume(not is_inside(layout, place))
    assume(not len(segments) or clearance(layout, np.zeros(1), here, 0.0)[0] > 0.01)
    ranges = caster_for(layout, profile).cast(*place, yaw)
    assert ranges.shape == (profile.beams,)
    assert_exact(ranges, segments, place, profile.angles + yaw, profile.range_max)


def test_beams_exactly_through_the_corners_of_a_square_see_them():
    ranges = cast(World(walls=(Wall(((-1, -1), (1, -1), (1, 1), (-1, 1)), closed=True),)))
    assert ranges[[45, 135, 225, 315]] == pytest.approx([math.sqrt(2)] * 4, abs=1e-9)
    assert ranges[[0, 90, 180, 270]] == pytest.approx([1.0] * 4, abs=1e-12)


def test_walls_are_seen_from_both_sides_and_solids_from_outside():
    wall = World(walls=(Wall(((1, -1), (1, 1))),))
    assert cast(wall)[180] == pytest.approx(1.0)
    assert cast(wall, 2.0, 0.0, math.pi)[180] == pytest.approx(1.0)
    assert np.isinf(cast(World(boxes=(Box((0, 0), (1, 1)),)))).all()  # from inside
    assert np.isinf(cast(World(walls=(Wall(((1, 0), (3, 0))),)))).all()  # edge on


def test_moving_faces_count_for_one_scan_only():
    caster = caster_for(build_layout(World()), PROFILES["default"])
    cart = np.array([[2.0, -0.5], [3.0, -0.5], [3.0, 0.5], [2.0, 0.5]])
    assert caster.cast(0.0, 0.0, 0.0, moving=faces(cart))[180] == pytest.approx(2.0)
    assert np.isinf(caster.cast(0.0, 0.0, 0.0)).all()


def test_nothing_beyond_range_max_is_seen():
    far = World(walls=(Wall(((3.6, -9), (3.6, 9))),))
    assert np.isinf(cast(far, name="lds01")).all()
    assert cast(far, 0.2, 0.0, 0.0, name="lds01")[0] == pytest.approx(3.4)
