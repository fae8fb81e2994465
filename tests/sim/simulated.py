"""A scenario of a few lines, simulated for a few seconds."""

from sim.messages import LASER_SCAN, decode
from sim.scenario_files import scenario_from_toml
from sim.simulation import Simulation

SECOND = 10**9  # [ns]


def simulate(text, commands=(), seconds=6.0, world="open"):
    """Return a simulation after its first seconds, and the messages that it sent."""
    scenario = scenario_from_toml(f'title = "x"\nworld = "{world}"\n{text}', "x")
    simulation = Simulation(scenario)
    return simulation, simulation.advance(round(seconds * SECOND), commands)


def scans_in(messages):
    """Return the decoded LaserScans among messages."""
    return [decode(m.data, LASER_SCAN) for m in messages if m.type == LASER_SCAN]
