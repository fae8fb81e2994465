"""Where a cart is: one pose at a time, or many at once."""

import numpy as np
import pytest

from sim.layout import Cart

BOX = np.array([[0.5, 0.3], [-0.5, 0.3], [-0.5, -0.3], [0.5, -0.3]])


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
