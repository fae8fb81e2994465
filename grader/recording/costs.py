"""What a node's computing really cost, as the judge measured it, against the lidar's period.

In virtual time computing takes no time, so a node that would be too slow for a robot drives as if
it were not. These numbers tell. They are of the machine that measured them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grader.recording.recording import Recording
from sim.lidar import PROFILES

MOST_LOAD = 1.1  # the measure has the host's own work in it


@dataclass(frozen=True)
class Costs:
    """Time that the node computed."""

    p50: float  # [s] a message of the robot, with all that followed until the next one
    p99: float  # [s]
    worst: float  # [s]
    late: int  # messages that cost more than the lidar's period
    period: float  # [s] of the lidar
    load: float  # [s] computed in each second of the scenario

    @property
    def keeps_up(self) -> bool:
        """The node computes no longer than the time there is."""
        return self.load <= MOST_LOAD


def costs_of(recording: Recording) -> Costs | None:
    """Return the cost of computing in a trial; None if the node got no message.

    A wait is no computing, and neither is what other programs on the machine took from the node:
    the smaller one of wall time and CPU time counts.
    """
    begun = 1 if recording.live is None else 0  # a program's start-up is not the scenario's
    compute = recording.compute
    spent = np.fmin(compute.wall, compute.cpu)[begun:]
    sent = {message.time / 1e9 for message in recording.delivered}
    costs = spent[[time in sent for time in compute.time[begun:].tolist()]]
    if not len(costs):
        return None
    period = lidar_period(recording)
    return Costs(
        p50=float(np.percentile(costs, 50)),
        p99=float(np.percentile(costs, 99)),
        worst=float(costs.max()),
        late=int((costs > period).sum()),
        period=period,
        load=float(spent.sum()) / recording.duration_s if recording.duration_s else 0.0,
    )


def lidar_period(recording: Recording) -> float:
    """Return the time from a scan to the next [s]."""
    lidar = recording.scenario.lidar
    return 1.0 / (lidar.rate or PROFILES[lidar.profile].rate)


def account_of(recording: Recording) -> list[str]:
    """Say in a sentence what computing cost, and in others if that is too much or took time."""
    costs = costs_of(recording)
    if costs is None:
        return []
    own = bool(np.isfinite(recording.compute.cpu).any())  # the node's, and no other program's
    said = [
        f"Compute: {_ms(costs.p50)} ms a message (p50), {_ms(costs.p99)} ms (p99), "
        f"{_ms(costs.worst)} ms at worst; the lidar's period is {_ms(costs.period)} ms"
        + ("" if own else ". By the clock: what else the machine had to do is in it")
    ]
    if recording.charged:
        said.append(
            "Computing took time in this run (--charge-compute): it depends on the machine, and "
            "another run differs"
        )
    elif not own:
        pass  # undecided
    elif not costs.keeps_up:
        said.append(
            f"WARNING: the node can't keep up: it computes {costs.load:.1f} s for each second. "
            f"On a robot like this machine it would do about {1 / costs.period / costs.load:.1f} "
            f"of {1 / costs.period:.0f} scans a second"
        )
    elif costs.late:
        times = "once" if costs.late == 1 else f"{costs.late} times"
        said.append(
            f"WARNING: {times} the node computed for longer than the lidar's period; "
            "on a robot the next scan has to wait meanwhile"
        )
    return said


def _ms(seconds: float) -> str:
    """Return milliseconds with as many digits as matter."""
    return f"{1e3 * seconds:.1f}" if seconds < 0.01 else f"{1e3 * seconds:.0f}"
