"""Turn a recording into the replay payload that the player draws (the page's JSON)."""

from __future__ import annotations

import base64
import json
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grader.course.students import public_seed
from grader.recording import account_of
from grader.recording.hands import deeds

if TYPE_CHECKING:
    from grader.recording import Recording, Scan
    from sim.layout import Cart

JsonDict = dict[str, Any]
Ghosts = Sequence[tuple[str, Mapping[str, Sequence[float]]]]  # names; tracks: t [s], x, y [m], yaw

TRUTH_RATE = 20.0  # [Hz] half of what the eye needs at 2x speed; the player interpolates
SCAN_RATE = 10.0  # [Hz]
CART_RATE = 10.0  # [Hz]
MAX_BEAMS = 360
MAX_SCANS = 300  # 300 scans of 360 beams are 288 kB of base64
MAX_COMMANDS = 4000
MAX_LOG_LINES = 1500
MAX_LOG_TEXT = 2000  # [characters] of one log line
MAX_LOG = 100_000  # [bytes] of all in JSON, where a character takes up to 12
MAX_OUTCOME = 400  # [characters] of how a run ended; it stands above the map
MAX_DETAIL = 8000  # [characters] of a traceback
MAX_SCAN_AGE = 10.0  # [s] an older stamp is wrong, not late

PLUS_INF, MINUS_INF, NOT_A_NUMBER = 65535, 65534, 65533
LONGEST_MM = 65532


def replay_payload(
    recording: Recording, moments: Sequence[Mapping[str, Any]], ghosts: Ghosts = ()
) -> JsonDict:
    """Return a run for the player: world, truth, commands, scans, goals, log, failing moments.

    It is downsampled (truth to 20 Hz, scans to 10 Hz and 360 beams) to keep reports small.
    """
    scenario = recording.scenario
    duration = float(recording.duration_s)
    return {
        "scenario": scenario.name,
        "title": scenario.title or scenario.name,
        "description": scenario.description,
        "seed": public_seed(recording.seed),
        "duration": _number(duration, 3),
        "bench": bool(scenario.bench),
        "robot": {"radius": _number(scenario.robot.radius, 3)},
        "world": {
            "walls": [_points(wall) for wall in recording.layout.walls],
            "solids": [_points(solid) for solid in recording.layout.solids],
        },
        "carts": [_cart(cart, duration) for cart in recording.layout.carts],
        "truth": _truth(recording),
        "commands": _commands(recording),
        "scans": _scans(recording.scans()),
        "goals": _goals(recording),
        "deeds": _deeds(recording),
        "ghosts": [{"name": name, **track} for name, track in ghosts],
        "log": _log(recording),
        "compute": _compute(recording),
        "outcome": {
            "kind": recording.outcome.kind,
            "text": _shorten(recording.outcome.text, MAX_OUTCOME),
            "at": _number(recording.outcome.at, 3),
            "detail": _shorten(recording.outcome.detail, MAX_DETAIL),
        },
        "moments": [dict(moment) for moment in moments],
    }


def moments_of(checks: Iterable[Mapping[str, Any]], scenario: str) -> list[JsonDict]:
    """Return the failing moments of a scenario, from the checks of a grading (result JSON)."""
    moments = [
        {
            "t": _number(check["time"], 3),
            "check": check["id"],
            "title": check["title"],
            "outcome": check["outcome"],
            **{key: check.get(key, "") for key in ("message", "expected", "actual", "help")},
        }
        for check in checks
        if check["outcome"] == "fail"
        and check.get("scenario") == scenario
        and check.get("time") is not None
    ]
    return sorted(moments, key=lambda moment: moment["t"] or 0.0)


# --- the parts of a replay -----------------------------------------------------------------


def _truth(recording: Recording) -> JsonDict:
    """Return the ground truth at 20 Hz; a bin keeps its smallest clearance and any contact."""
    truth = recording.truth
    t = np.asarray(truth.t, dtype=np.float64) * 1e-9
    starts = _thin(t, TRUTH_RATE)
    if not len(starts):
        return {key: [] for key in ("t", "x", "y", "yaw", "v", "w", "clearance", "contact")}
    return {
        "t": _numbers(t[starts], 3),
        "x": _numbers(np.asarray(truth.x)[starts], 3),
        "y": _numbers(np.asarray(truth.y)[starts], 3),
        "yaw": _numbers(np.asarray(truth.yaw)[starts], 3),
        "v": _numbers(np.asarray(truth.v)[starts], 3),
        "w": _numbers(np.asarray(truth.w)[starts], 3),
        "clearance": _numbers(np.minimum.reduceat(np.asarray(truth.clearance), starts), 3),
        "contact": [
            int(touched) for touched in np.logical_or.reduceat(np.asarray(truth.contact), starts)
        ],
    }


def _commands(recording: Recording) -> JsonDict:
    twists = recording.twists()
    keep = slice(MAX_COMMANDS)
    return {
        "t": _numbers(twists.t[keep], 3),
        "v": _numbers(twists.linear_x[keep], 3),
        "w": _numbers(twists.angular_z[keep], 3),
    }


def _scans(scans: Sequence[Scan]) -> JsonDict | None:
    """Return the scans as base64 of uint16 millimetres; scans of another layout are all NaN."""
    if not scans:
        return None
    layout = Counter(_layout_of(scan) for scan in scans if len(scan.ranges))
    if not layout:
        return None
    angle_min, increment, range_max, beams = layout.most_common(1)[0][0]
    times = np.array([scan.t for scan in scans], dtype=np.float64)
    chosen = _thin(times, SCAN_RATE)
    chosen = chosen[:: max(1, math.ceil(len(chosen) / MAX_SCANS))]
    every = max(1, math.ceil(beams / MAX_BEAMS))
    kept_beams = len(range(0, beams, every))
    rows = np.full((len(chosen), kept_beams), NOT_A_NUMBER, dtype="<u2")
    for row, index in zip(rows, chosen, strict=True):
        if len(scans[index].ranges) == beams:
            row[:] = millimetres(scans[index].ranges[::every])
    return {
        "t": _numbers(times[chosen], 3),
        "stamp": [_number(_stamp(scans[index]), 3) for index in chosen],
        "angle_min": _number(angle_min, 6),
        "angle_increment": _number(increment * every, 8),
        "range_max": _number(range_max, 3),
        "beams": kept_beams,
        "mm": base64.b64encode(rows.tobytes()).decode("ascii"),
    }


def millimetres(ranges: NDArray[np.floating[Any]]) -> NDArray[np.uint16]:
    """Return ranges (beams,) [m] as uint16 [mm]; 65535 = +inf, 65534 = -inf, 65533 = NaN."""
    metres = np.asarray(ranges, dtype=np.float64)
    finite = np.isfinite(metres)
    mm = np.full(metres.shape, NOT_A_NUMBER, dtype="<u2")
    mm[finite] = np.clip(np.rint(metres[finite] * 1000.0), 0, LONGEST_MM).astype("<u2")
    mm[np.isposinf(metres)] = PLUS_INF
    mm[np.isneginf(metres)] = MINUS_INF
    return mm


def _layout_of(scan: Scan) -> tuple[float, float, float, int]:
    return (
        float(scan.first_angle),
        float(scan.angle_increment),
        float(scan.range_max),
        len(scan.ranges),
    )


def _stamp(scan: Scan) -> float:
    """Return when the scan was taken [s since the start]; its arrival if the stamp is wrong."""
    return scan.stamp if 0.0 <= scan.t - scan.stamp <= MAX_SCAN_AGE else scan.t


def _cart(cart: Cart, duration: float) -> JsonDict:
    times = np.arange(0.0, max(duration, 0.0) + 1.0 / CART_RATE, 1.0 / CART_RATE)
    x, y, yaw = cart.poses(times).T
    return {
        "polygon": _points(cart.polygon),
        "t": _numbers(times, 2),
        "x": _numbers(x, 3),
        "y": _numbers(y, 3),
        "yaw": _numbers(yaw, 3),
    }


def _goals(recording: Recording) -> list[JsonDict]:
    goals = recording.goals()
    return [
        {"t": _number(t, 3), "x": _number(x, 3), "y": _number(y, 3)}
        for t, x, y in zip(goals.t, goals.x, goals.y, strict=True)
    ]


def _deeds(recording: Recording) -> list[JsonDict]:
    told = ((deed.at, f"{deed.text}: {deed.said}".removesuffix(": ")) for deed in deeds(recording))
    return [{"t": _number(at, 3), "text": _shorten(text)} for at, text in told]


def _compute(recording: Recording) -> list[str]:
    return account_of(recording)


def _log(recording: Recording) -> list[JsonDict]:
    lines, shown, left = recording.log, list[JsonDict](), MAX_LOG
    for line in lines[:MAX_LOG_LINES]:
        text = _shorten(line.text)
        left -= len(json.dumps(text))
        if left < 0:
            break
        shown.append({"t": _number(line.time * 1e-9, 3), "level": line.level, "text": text})
    if len(lines) > len(shown) or recording.log_truncated:
        text = "(the node logged more; this replay leaves the rest out)"
        shown.append({"t": shown[-1]["t"] if shown else 0.0, "level": "warn", "text": text})
    return shown


# --- numbers -------------------------------------------------------------------------------


def _thin(times: NDArray[np.float64], rate: float) -> NDArray[np.intp]:
    """Return the index of the first sample in each time bin of 1/rate seconds."""
    if not len(times):
        return np.zeros(0, dtype=np.intp)
    bins = np.floor(times * rate + 1e-6)
    return np.flatnonzero(np.diff(bins, prepend=-np.inf) > 0)


def _shorten(text: str, most: int = MAX_LOG_TEXT) -> str:
    return text if len(text) <= most else text[: most - 1] + "…"


def _number(value: Any, digits: int) -> float | None:
    """Return a rounded number; None for NaN and infinity, which JSON does not have."""
    number = float(value)
    return round(number, digits) + 0.0 if math.isfinite(number) else None


def _numbers(values: Iterable[Any], digits: int) -> list[float | None]:
    return [_number(value, digits) for value in values]


def _points(points: Iterable[Any]) -> list[list[float | None]]:
    return [_numbers(point, 3) for point in points]
