"""The distance from the robot's edge to walls, solids and carts."""

import numpy as np
import pytest

from sim.clearance import clearance
from sim.placement import build_layout
from sim.world import MovingCart, Wall, World


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
