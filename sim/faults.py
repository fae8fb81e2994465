"""Faults of sensors and links: noise on readings, and messages that are late or lost.

Everything here is a pure function of the scenario's `[faults]` and a sensor's own generator.
"""

import math
import zlib

import numpy as np
from numpy.typing import NDArray

from sim.layout import Floats
from sim.scenario import Faults

Times = NDArray[np.int64]  # [ns] since the scenario's start


def sensor_rng(seed: int, sensor: str) -> np.random.Generator:
    """Return the sensor's own generator, so that no sensor shifts another's noise."""
    return np.random.default_rng((seed, zlib.crc32(sensor.encode())))


def measured(ranges: Floats, faults: Faults, rng: np.random.Generator) -> Floats:
    """Return the (n,) ranges [m] with noise and dropped beams; inf stays inf."""
    result = ranges
    if faults.range_noise:
        result = result + faults.range_noise * rng.standard_normal(len(ranges))
        result = np.maximum(result, 0.0)
    if faults.beam_dropout:
        result = np.where(rng.random(len(ranges)) < faults.beam_dropout, math.inf, result)
    return result


def speckle(
    readings: NDArray[np.float32], faults: Faults, rng: np.random.Generator
) -> NDArray[np.float32]:
    """Return the (n,) readings, some of them NaN as after an error of the sensor."""
    if not faults.nan_speckle:
        return readings
    erroneous = rng.random(len(readings)) < faults.nan_speckle
    return np.where(erroneous, np.float32(math.nan), readings)


def survivors(
    times: Times, loss: float, rng: np.random.Generator, blackout: tuple[tuple[float, float], ...]
) -> NDArray[np.bool_]:
    """Return which of the (n,) messages measured at these times [ns] arrive at all."""
    arrives = np.ones(len(times), bool)
    if loss:
        arrives &= rng.random(len(times)) >= loss
    for begin, end in blackout:
        arrives &= (times < begin * 1e9) | (times > end * 1e9)
    return arrives


def deliveries(times: Times, latency: float, jitter: float, rng: np.random.Generator) -> Times:
    """Return when messages measured at these (n,) times arrive [ns], never out of order."""
    late = times + round(latency * 1e9)
    if jitter:
        late = late + np.rint(rng.random(len(times)) * jitter * 1e9).astype(np.int64)
    return np.maximum.accumulate(late)
