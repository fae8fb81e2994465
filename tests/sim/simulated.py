"""A scenario of a few lines, simulated or refused; and a world with one of everything."""

import numpy as np
import pytest

from sim.errors import InputError
from sim.messages import LASER_SCAN, decode
from sim.placement import build_layout
from sim.scenario_files import scenario_from_toml
from sim.simulation import Simulation
from sim.world import Box, Clutter, MovingCart, Pillar, Wall, World

SECOND = 10**9  # [ns]
INLINE = 'title = "x"\n[world]\n'
CLUTTER = INLINE + "[[world.clutter]]\narea = [[1, -1], [2, 1]]\n"
CROWD = World(
    walls=(Wall(((-3, -3), (6, -3), (6, 3))),),
    boxes=(Box((2, 1), (0.5, 1.0), 30.0),),
    pillars=(Pillar((0, 2), 0.2),),
    clutter=(Clutter(((1, -2), (5, 2)), 15, keep_clear=((3, 0, 0.5),)),),
    carts=(MovingCart((0.6, 0.4), ((0, 3, -3), (6, 3, 3))),),
)


def crowd(seed=1, **options):
    """Return the layout of the crowded world."""
    return build_layout(CROWD, rng=np.random.default_rng(seed), **options)


def simulate(text, commands=(), seconds=6.0, world="open"):
    """Return a simulation after its first seconds, and the messages that it sent."""
    scenario = scenario_from_toml(f'title = "x"\nworld = "{world}"\n{text}', "x")
    simulation = Simulation(scenario)
    return simulation, simulation.advance(round(seconds * SECOND), commands)


def refusal(read, *given):
    """Return what is said of an input that is refused."""
    with pytest.raises(InputError) as caught:
        read(*given)
    assert caught.value.__cause__ is None
    return str(caught.value)


def scans_in(messages):
    """Return the decoded LaserScans among messages."""
    return [decode(m.data, LASER_SCAN) for m in messages if m.type == LASER_SCAN]
