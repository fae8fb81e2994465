"""Entries of a scenario's lists that stand for several: ramps, and what comes again.

In a bench `{ ramp = [5.0, 4.4], scans = 13 }` has fills from 5.0 to 4.4 m, each labelled with its
distance; `{}` in a label stands for it, and where there are patches without a range, they have it
instead. `{ each = ["0.30", "0.29"] }` is the same for any distances, as their labels write them.
`{ repeat = 24, of = [{ … }, { … }] }` are these scans, 24 times in turn.

In a script `every` is the time from one turn to the next [s]:
`{ repeat = 9, every = 0.2, of = [{ at = 1.0, … }, { at = 1.1, … }] }`, or, of one event,
`{ at = 1.0, repeat = 9, every = 0.2, … }`.
"""

import math
import re
from collections.abc import Callable
from typing import Any

from sim.errors import InputError
from sim.scenario import MAX_BENCH_SCANS
from sim.toml_input import shown

RAMP, EACH, REPEAT, EVERY, OF = "ramp", "each", "repeat", "every", "of"
DISTANCE = re.compile(r"\d+(\.\d+)?", re.ASCII)  # as a label writes it


def scans_of(bench: Any, at: str) -> Any:
    """Return the scans of a bench, each spelled out; what is no list is left as it is."""
    return _spelled_out(bench, at, _scans)


def events_of(script: Any, at: str) -> Any:
    """Return the events of a script, each spelled out; what is no list is left as it is."""
    return _spelled_out(script, at, _events)


def _spelled_out(entries: Any, at: str, spell: Callable[[dict[str, Any], str], list[Any]]) -> Any:
    if not isinstance(entries, list):
        return entries
    found: list[Any] = []
    for i, entry in enumerate(entries):
        found += spell(entry, f"{at}.{i}") if isinstance(entry, dict) else [entry]
    return found


def _scans(entry: dict[str, Any], at: str) -> list[Any]:
    if OF not in entry:
        return _scan_or_more(entry, at)
    _refuse_others(entry, (REPEAT, OF), at)
    turn: list[Any] = _spelled_out(_list_of(entry, at), f"{at}.{OF}", _scan_or_more)
    return _times(entry, turn, at) * turn


def _scan_or_more(entry: dict[str, Any], at: str) -> list[Any]:
    """Return the scan, or those of a ramp or of each distance: in fill or patches, and label."""
    if RAMP in entry:
        own, distances = [RAMP, "scans"], _ramp(entry, at)
    elif EACH in entry:
        own, distances = [EACH], _each(entry, at)
    else:
        return [entry]
    rest = {key: value for key, value in entry.items() if key not in own}
    made = []
    for text in distances:
        scan = {**rest, "label": str(rest.get("label", "{}")).replace("{}", f"{text} m")}
        if "patches" in rest:
            scan["patches"] = [{"range": float(text), **patch} for patch in rest["patches"]]
        else:
            scan["fill"] = float(text)
        made.append(scan)
    return made


def _events(entry: dict[str, Any], at: str) -> list[Any]:
    if OF in entry:
        _refuse_others(entry, (REPEAT, EVERY, OF), at)
        turn = _list_of(entry, at)
    elif REPEAT in entry:
        turn = [{key: value for key, value in entry.items() if key not in (REPEAT, EVERY)}]
    else:
        return [entry]
    count, every = _times(entry, turn, at), entry.get(EVERY)
    if every is None or not _is_number(every):
        raise InputError(f"{at}: {EVERY} = {shown(every)}: expected seconds from turn to turn")
    return [_later(event, i * every) for i in range(count) for event in turn]


def _list_of(entry: dict[str, Any], at: str) -> list[Any]:
    entries = entry[OF]
    if not isinstance(entries, list):
        raise InputError(f"{at}: {OF} = {shown(entries)}: expected a list")
    return entries


def _times(entry: dict[str, Any], turn: list[Any], at: str) -> int:
    count, most = entry.get(REPEAT), MAX_BENCH_SCANS // max(1, len(turn))
    if not isinstance(count, int) or not 1 <= count <= most:
        raise InputError(f"{at}: {REPEAT} = {shown(count)}: expected a count from 1 to {most}")
    return count


def _refuse_others(entry: dict[str, Any], known: tuple[str, ...], at: str) -> None:
    for key in sorted(entry.keys() - known):
        raise InputError(f"{at}: unknown key '{key}' beside '{OF}'")


def _later(event: Any, seconds: float) -> Any:
    if not isinstance(event, dict) or not _is_number(event.get("at")):
        return event  # what is wrong with it is said as of any other
    return {**event, "at": round(event["at"] + seconds, 6)}


def _ramp(entry: dict[str, Any], at: str) -> list[str]:
    ends, count = entry[RAMP], entry.get("scans")
    if not isinstance(ends, list) or len(ends) != 2 or not all(map(_is_number, ends)):
        raise InputError(f"{at}: {RAMP} = {shown(ends)}: expected two distances, [5.0, 0.4]")
    if not isinstance(count, int) or not 2 <= count <= MAX_BENCH_SCANS:
        raise InputError(f"{at}: scans = {shown(count)}: expected at least 2 for a {RAMP}")
    return [str(round(ends[0] + (ends[1] - ends[0]) * i / (count - 1), 6)) for i in range(count)]


def _each(entry: dict[str, Any], at: str) -> list[str]:
    texts = entry[EACH]
    if not (isinstance(texts, list) and texts and all(map(_is_distance, texts))):
        what = 'expected distances as the labels write them, ["0.30", "5"]'
        raise InputError(f"{at}: {EACH} = {shown(texts)}: {what}")
    return texts


def _is_distance(text: Any) -> bool:
    return isinstance(text, str) and DISTANCE.fullmatch(text) is not None


def _is_number(value: Any) -> bool:
    return isinstance(value, float | int) and math.isfinite(value)
