"""How well the robot keeps up with time: rates, lateness and overruns in a window."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Health:
    """What was measured in a window of real time."""

    seconds: float  # its length [s]
    rates: Mapping[str, tuple[float, float]]  # topic → target (0: sporadic) and actual [Hz]
    worst_lateness: float  # of a message that was sent [s]
    overruns: int  # number of times that the robot was too late and let its time slip
    slipped: float  # by this much in all [s]

    @property
    def keeps_up(self) -> bool:
        """Say whether the robot kept up all the time."""
        return self.overruns == 0


class HealthMeter:
    """Counts what `take` returns, and then starts over.

    Parameters
    ----------
    rates
        Topic → nominal rate in scenario time [Hz].
    """

    def __init__(self, rates: Mapping[str, float]) -> None:
        self._rates = dict(rates)
        self._counts: Counter[str] = Counter()
        self._worst = 0.0  # [s]
        self._overruns = 0
        self._slipped = 0.0  # [s]

    def sent(self, topic: str, late: float) -> None:
        """Note a message that left `late` [s] after its time."""
        self._counts[topic] += 1
        self._worst = max(self._worst, late)

    def slipped(self, seconds: float) -> None:
        """Note that the robot's time slipped by `seconds` [s]."""
        self._overruns += 1
        self._slipped += seconds

    def take(self, seconds: float, rate: float) -> Health:
        """Return what was noted in the last `seconds` [s] of a robot at this rate; start over."""
        rates = {
            topic: (nominal * rate, self._counts[topic] / seconds)
            for topic, nominal in self._rates.items()
        }
        health = Health(seconds, rates, self._worst, self._overruns, self._slipped)
        self._counts.clear()
        self._worst, self._overruns, self._slipped = 0.0, 0, 0.0
        return health
