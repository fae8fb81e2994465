"""What the command line asks for."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Options:
    """Defaults of the node's parameters, and the options that are no parameters."""

    scenario: str = "demo_wall"  # a name, or a file
    lidar: str | None = None  # a profile; None: the scenario's
    rate: float = 1.0  # scenario seconds in a second
    seed: int | None = None  # None: the scenario's
    clock: bool = False  # send /clock; stamps are in simulated time
    wait: bool = False  # until somebody subscribes
    duration: float | None = None  # [s] in scenario time; None: until it is stopped
    once: bool = False  # for the scenario's own duration
    foxglove: int | None = None  # port on loopback; 0: any; None: no viewer
    record: Path | None = None  # folder of a new bag
