"""The worlds of the course; mistakes in world files are in test_scenario_errors.py."""

import pytest

from sim.world import load_world, world_names


@pytest.mark.parametrize("name", world_names())
def test_every_world_says_what_it_is(name):
    assert load_world(name).description
