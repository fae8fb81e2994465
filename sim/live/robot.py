"""The mock robot in real time: a simulation, and a timeline that says when it is due.

It knows nothing of ROS: `node` publishes what `step` returns, and passes on what it hears.
"""

import msgspec

from sim.live.health import HealthMeter
from sim.live.timeline import Timeline
from sim.live.topics import patience, sent_topics
from sim.messages import Message, with_epoch
from sim.scenario import Scenario
from sim.sensors import SENSORS
from sim.simulation import Simulation

IDLE_TICK_NS = 100_000_000  # between two steps at most [ns], also when no message is due
CLOCK_TICK_NS = 10_000_000  # the same with /clock: a step of the physics


class LiveRobot:
    """A robot that runs a scenario in real time, once its timeline runs.

    Raises InputError: the robot's start is not free, or the clutter does not fit.

    Parameters
    ----------
    scenario
        Its duration is how long the robot runs.
    timeline
        The robot's time.
    tick
        Between two steps at most [ns].
    """

    def __init__(self, scenario: Scenario, timeline: Timeline, tick: int = IDLE_TICK_NS) -> None:
        self.simulation = Simulation(scenario)
        self.timeline = timeline
        self.rates = sent_topics(scenario)
        self.meter = HealthMeter(self.rates)
        self._patience = patience(self.rates)  # [s]
        self.tick = tick
        self._commands: list[tuple[int, float, float]] = []

    @property
    def over(self) -> bool:
        """Say whether the scenario's duration is over."""
        return self.simulation.now >= self.simulation.scenario.duration_ns

    @property
    def ros_now(self) -> int:
        """The ROS time [ns since 1970]; what /clock says if it is simulated."""
        return self.timeline.ros_time(self.simulation.now)

    def due(self) -> float:
        """Return in how many real seconds the next `step` is due; inf while paused."""
        return self.timeline.seconds_until(self._moment())

    def step(self) -> tuple[list[Message], float]:
        """Advance to the next moment, which is due, and return its messages and the slip [s].

        A robot that is later than two periods of its fastest sensor does not catch up in a burst
        of messages: its time slips by as much as it is late, and it goes on from there.
        """
        moment = self._moment()
        late = max(0.0, -self.timeline.seconds_until(moment))
        slip = late if late > self._patience else 0.0
        if slip:
            self.timeline.slip_to(moment)
            self.meter.slipped(slip)
        messages = self.simulation.advance(moment, self._commands)
        self._commands = []
        for message in messages:
            self.meter.sent(message.topic, late)
        return [with_epoch(message, self.timeline.epoch) for message in messages], slip

    def command(self, linear: float, angular: float) -> None:
        """Take a command [m/s, rad/s] that takes effect now; while paused it is ignored."""
        if self.timeline.running:
            now = max(self.timeline.now(), self.simulation.now)
            self._commands.append((now, linear, angular))

    def planned(self, seed: int) -> Simulation:
        """Return a simulation of the scenario with this seed, at its start.

        Raises InputError: the robot's start is not free with this seed, or the clutter does not
        fit.
        """
        return Simulation(self.simulation.scenario, seed)

    def begin(self, simulation: Simulation) -> None:
        """Run this simulation from now on."""
        self.simulation = simulation
        self._commands = []
        self.timeline.restart()

    def _moment(self) -> int:
        """Return the time of the next step [ns]."""
        simulation = self.simulation
        tick = simulation.now + self.tick - simulation.now % self.tick
        moment = min(tick, simulation.scenario.duration_ns)
        event = simulation.next_event()
        return moment if event is None else min(moment, event)


def clock_tick(rate: float) -> int:
    """Return the scenario time between two /clock [ns]: 10 ms, and at least 10 ms of real time."""
    return round(CLOCK_TICK_NS * max(1.0, rate))


def rehearse(scenario: Scenario) -> None:
    """Make a message of each sensor: what is set up on first use takes 0.1 s.

    Raises InputError: the robot's start is not free, or the clutter does not fit.
    """
    tables = {sensor.table: getattr(scenario, sensor.table) for sensor in SENSORS}
    soon = {
        name: msgspec.structs.replace(table, phase=type(table)().phase)
        for name, table in tables.items()
    }
    short = msgspec.structs.replace(scenario, duration=0.1, **soon)
    for message in Simulation(short).advance(short.duration_ns):
        with_epoch(message, 0)
