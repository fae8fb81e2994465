"""A node that is a function: what it does with each scan, without a process."""

from collections.abc import Callable

from grader.checks.ahead import front_distance
from grader.recording import COMPLETED, Outcome, Recording, Scan, views
from sim.messages import EPOCH_NS, SCAN_TOPIC, twist
from sim.scenario import Scenario
from sim.simulation import Simulation

Policy = Callable[[Scan], float]


def drive_by(policy: Policy, scenario: Scenario, outcome: Outcome | None = None) -> Recording:
    """Drive in a scenario with `linear.x` as the policy says, one command for each scan."""
    simulation = Simulation(scenario)
    delivered, published, commands = [], [], []
    while (due := simulation.next_event()) is not None:
        messages = simulation.advance(due, commands)
        delivered += messages
        commands = []
        for scan in views.scans((m for m in messages if m.topic == SCAN_TOPIC), EPOCH_NS, 0.0):
            speed = policy(scan)
            published.append(twist(time=due, linear_x=speed, topic="/cmd_vel"))
            commands = [(due, speed, 0.0)]
    simulation.advance(simulation.end, commands)
    return Recording(
        scenario=simulation.scenario,
        layout=simulation.layout,
        seed=simulation.seed,
        duration_s=simulation.now / 1e9,
        delivered=tuple(delivered),
        published=tuple(published),
        truth=simulation.truth(),
        outcome=outcome or Outcome(COMPLETED, ""),
        endpoints=(),
    )


def careful(scan: Scan) -> float:
    """Drive as exercise 1 asks for."""
    distance = front_distance(scan)
    if distance is None or distance < 0.5:
        return 0.0
    return 0.5 if distance >= 1.0 else 0.15


def reckless(scan: Scan) -> float:
    """Never brake."""
    return 0.5


def timid(scan: Scan) -> float:
    """Stand, whatever is there."""
    return 0.0
