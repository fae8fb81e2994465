"""What somebody did to a node in a run: parameters set, and the e-stop pressed or released."""

from __future__ import annotations

import itertools
import re
from typing import NamedTuple

from grader.recording.recording import Recording

SETTER = "parameter_setter.py"


class Deed(NamedTuple):
    """One thing that was done."""

    at: float  # [s]
    text: str  # "speed:=0.2", "e-stop pressed"
    node: str = ""  # whose parameter
    said: str = ""  # what the node answered: "accepted", "refused: expected 0.0 to 0.5 m/s"


def deeds(recording: Recording) -> list[Deed]:
    """Return what was done by the scenario's script and its setters of parameters, by time."""
    stops = [event for event in recording.scenario.script if event.e_stop is not None]
    stops = [next(alike) for _, alike in itertools.groupby(stops, lambda event: event.e_stop)]
    found = [Deed(e.at, f"e-stop {'pressed' if e.e_stop else 'released'}") for e in stops]
    setters = [program for program in recording.scenario.program if program.file == SETTER]
    for node, *orders in (setter.arguments for setter in setters):
        for at, text in (order.split(maxsplit=1) for order in orders):
            parts = [] if text.endswith("?") else text.split(", ")
            time = float(at)
            found += [Deed(time, part, node, _answer(recording, time, part)) for part in parts]
    return sorted((each for each in found if each.at <= recording.duration_s), key=lambda d: d.at)


def _answer(recording: Recording, at: float, text: str) -> str:
    """Return what the setter logged of the node's answer; "": it has not come."""
    begin = f"{text}: "
    lines = (line.text for line in recording.log if line.t >= at - 1e-6)
    said = next((line.removeprefix(begin) for line in lines if line.startswith(begin)), "")
    return re.sub("^refused (?=.)", "refused: ", said)
