"""Plots of scans. matplotlib is imported with the first plot.

The colours are Okabe and Ito's; each has its own marker, so that nothing depends on colour alone.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grader.errors import InputError
from grader.models.features import FRONT_EDGE, NAMES, scan_features
from grader.notebook.figures import follow_theme
from grader.recording import Scan
from sim.lidar import PROFILES
from sim.messages import LASER_SCAN, SCAN_TOPIC, decode
from sim.simulation import Simulation

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]

BLUE, ORANGE, GREEN, RED, GREY = "#0072b2", "#e69f00", "#009e73", "#d55e00", "#6e7781"
ROBOT_RADIUS = 0.17  # [m]
SECTORS = (  # label, colour, marker
    ("front, |θ| ≤ 60°", BLUE, "o"),
    ("left, θ > 60°", ORANGE, "^"),
    ("right, θ < -60°", GREEN, "s"),
)
LEFT, RIGHT = (ORANGE, "^"), (GREEN, "s")


def plot_scan(scan: Any, lidar: str | None, at: float, ax: Axes | None) -> Axes:
    """See `grader.notebook.show_scan`."""
    found, title = as_scan(scan, lidar=lidar, at=at)
    axes = _map(found, title, ax)
    usable = _usable(found)
    x, y = _points(found, usable)
    axes.plot(y, x, "o", color=BLUE, markersize=3, label=f"{usable.sum()} distances")
    _legend(axes)
    return axes


def plot_features(scan: Any, lidar: str | None, at: float, ax: Axes | None) -> Axes:
    """See `grader.notebook.show_features`."""
    found, title = as_scan(scan, lidar=lidar, at=at)
    axes = _map(found, title, ax)
    degrees = _degrees(found)
    usable = _usable(found)
    masks = np.abs(degrees) <= FRONT_EDGE + 0.01, degrees > FRONT_EDGE, degrees < -FRONT_EDGE
    values = scan_features(found)
    reach = axes.get_ylim()[1]
    for sign in (1, -1):
        edge = sign * math.radians(FRONT_EDGE)
        axes.plot([0, reach * math.sin(edge)], [0, reach * math.cos(edge)], "--",
                  color=GREY, linewidth=1)  # fmt: skip
    for (label, colour, marker), mask, least in zip(SECTORS, masks, values[[0, 3, 4]], strict=True):
        x, y = _points(found, usable & mask)
        axes.plot(y, x, marker, color=colour, markersize=3, linestyle="none", label=label)
        if not math.isnan(least):
            _ring_nearest(axes, found, usable & mask, colour)
    if not math.isnan(values[1]):
        arc = np.radians(np.linspace(-FRONT_EDGE, FRONT_EDGE, 61))
        axes.plot(values[1] * np.sin(arc), values[1] * np.cos(arc), ":", color=BLUE,
                  label="mean of the front")  # fmt: skip
    _legend(axes)
    said = "\n".join(f"{name}  {_metres(x)}" for name, x in zip(NAMES, values, strict=True))
    axes.text(1.03, 0.02, said, transform=axes.transAxes, fontsize="small", va="bottom",
              bbox={"boxstyle": "round", "facecolor": "white", "edgecolor": GREY})  # fmt: skip
    return axes


def plot_left_right(scan: Any, lidar: str | None, at: float, ax: Axes | None) -> Axes:
    """See `grader.notebook.show_left_right`."""
    found, title = as_scan(scan, lidar=lidar, at=at)
    axes = ax if ax is not None else _new_axes((8.0, 4.0))
    degrees = _degrees(found)
    order = np.argsort(degrees)
    ranges = np.where(_usable(found), found.ranges, np.nan)
    mirrored = np.interp(-degrees[order], degrees[order], ranges[order], period=360.0)
    axes.plot(degrees[order], mirrored, "--", color=RED, linewidth=1.2,
              label="mirrored: beams counted the wrong way")  # fmt: skip
    for (colour, marker), side, label in (
        (LEFT, degrees > 0, "left, θ > 0"),
        (RIGHT, degrees < 0, "right, θ < 0"),
    ):
        axes.plot(degrees[side], ranges[side], marker, color=colour, markersize=3, label=label)
    axes.axvline(0.0, color=GREY, linewidth=1)
    axes.set(xlabel="angle θ [°]: left is positive", ylabel="distance [m]", title=title)
    axes.set_ylim(bottom=0.0)
    axes.invert_xaxis()  # left of ahead is left in the plot
    axes.grid(alpha=0.3)
    axes.set_xticks(range(-180, 181, 45))
    axes.text(0.0, 0.02 * axes.get_ylim()[1], f"  ahead: reading {np.argmin(np.abs(degrees))}",
              fontsize="small", color=GREY)  # fmt: skip
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=3, fontsize="small",
                frameon=False)  # fmt: skip
    return axes


def as_scan(value: Any, *, lidar: str | None = None, at: float = 0.0) -> tuple[Scan, str]:
    """Convert a value to a scan; return it with a title for its plot.

    Raises InputError: the value has none of the forms that `show_scan` takes.
    """
    if isinstance(value, str | Path):
        return scan_of(str(value), lidar=lidar, at=at)
    if hasattr(value, "ranges") and hasattr(value, "angle_min"):
        return _of_message(value), "Scan"
    if isinstance(value, tuple) and len(value) in (3, 5) and np.ndim(value[0]) == 1:
        return _of_fields(*value), "Scan"
    try:
        ranges = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        ranges = np.empty(0)
    profile = PROFILES["default"]
    if ranges.shape != (profile.beams,):
        raise InputError(
            "expected a scenario's name, a LaserScan, (ranges, angle_min, angle_increment[, "
            f"range_min, range_max]) or {profile.beams} ranges; got {type(value).__name__}"
        )
    limits = profile.range_min, profile.range_max
    return _of_fields(ranges, profile.angle_min, profile.angle_increment, *limits), "Scan"


def scan_of(scenario: str, *, lidar: str | None = None, at: float = 0.0) -> tuple[Scan, str]:
    """Return the first scan of a scenario at or after a time [s]; the robot stands still.

    Raises InputError: there is no such scenario, or no such scan in it.
    """
    from grader.drive import scenario_for  # noqa: PLC0415

    chosen = scenario_for(scenario, lidar=lidar)
    simulation = Simulation(chosen)
    end = chosen.duration_ns
    while (due := simulation.next_event()) is not None and due <= end:
        for message in simulation.advance(due):
            if message.topic == SCAN_TOPIC and message.time >= round(at * 1e9):
                scan = decode(message.data, LASER_SCAN)
                title = f"{chosen.title or chosen.name}, {message.time / 1e9:.2f} s"
                return _of_message(scan), title
    raise InputError(f"{scenario}: no scan at {at:g} s or later; it lasts {chosen.duration:g} s")


def _of_message(scan: Any) -> Scan:
    limits = getattr(scan, "range_min", 0.0), getattr(scan, "range_max", math.inf)
    return _of_fields(scan.ranges, scan.angle_min, scan.angle_increment, *limits)


def _of_fields(
    ranges: Any, angle_min: Any, increment: Any, range_min: Any = 0.0, range_max: Any = math.inf
) -> Scan:
    return Scan(
        t=0.0,
        stamp=0.0,
        angle_min=float(angle_min),
        angle_increment=float(increment),
        range_min=float(range_min),
        range_max=float(range_max),
        ranges=np.asarray(ranges, dtype=np.float32),
    )


# --- drawing -------------------------------------------------------------------------------------


def _new_axes(size: tuple[float, float]) -> Axes:
    try:
        import matplotlib.pyplot as plt  # noqa: PLC0415
    except ImportError:
        raise InputError(
            "plots need matplotlib, which is not installed here: run `pip install matplotlib`, "
            "or prepare() in a notebook"
        ) from None
    figure, axes = plt.subplots(figsize=size)
    follow_theme(figure)
    return axes


def _map(scan: Scan, title: str, ax: Axes | None) -> Axes:
    """Return axes with the robot, seen from above, and the readings that are no distances."""
    axes = ax if ax is not None else _new_axes((7.0, 5.0))
    usable = _usable(scan)
    reach = 1.12 * float(scan.ranges[usable].max()) if usable.any() else 1.0
    reach = max(reach, 1.0)
    turn = np.linspace(0.0, math.tau, 73)
    axes.fill(ROBOT_RADIUS * np.cos(turn), ROBOT_RADIUS * np.sin(turn), color=GREY, alpha=0.5)
    axes.annotate("", (0.0, 0.16 * reach + ROBOT_RADIUS), (0.0, 0.0),
                  arrowprops={"arrowstyle": "-|>", "color": "black"})  # fmt: skip
    axes.text(0.0, 0.18 * reach + ROBOT_RADIUS, "ahead", ha="center", fontsize="small")
    for mask, marker, label in (
        (np.isposinf(scan.ranges), ".", "+inf: nothing in range"),
        (np.isneginf(scan.ranges), "x", "-inf: closer than range_min"),
    ):
        if mask.any():
            angle, radius = scan.angles[mask], reach if label.startswith("+") else ROBOT_RADIUS
            axes.plot(radius * np.sin(angle), radius * np.cos(angle), marker, color=GREY,
                      markersize=4 if marker == "x" else 2,
                      label=f"{mask.sum()} readings {label}")  # fmt: skip
    rest = len(scan.ranges) - int(usable.sum()) - int(np.isinf(scan.ranges).sum())
    if rest:
        axes.plot([], [], " ", label=f"{rest} readings NaN or out of range: not drawn")
    axes.set(
        xlabel="to the left of the robot [m]",
        ylabel="ahead of the robot [m]",
        title=title,
        xlim=(reach * 1.04, -reach * 1.04),  # left is left
        ylim=(-reach * 1.04, reach * 1.04),
        aspect="equal",
    )
    axes.grid(alpha=0.3)
    return axes


def _legend(axes: Axes) -> None:
    axes.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0), fontsize="small", frameon=False)


def _ring_nearest(axes: Axes, scan: Scan, mask: NDArray[np.bool_], colour: str) -> None:
    """Mark a sector's nearest point, whose distance is a feature."""
    if not mask.any():
        return
    nearest = int(np.flatnonzero(mask)[np.argmin(scan.ranges[mask])])
    only = np.zeros(len(mask), dtype=bool)
    only[nearest] = True
    x, y = _points(scan, only)
    axes.plot([0, *y], [0, *x], "-", color=colour, linewidth=1)
    axes.plot(y, x, "o", markersize=11, markerfacecolor="none", markeredgecolor=colour)


def _usable(scan: Scan) -> NDArray[np.bool_]:
    """Return which readings are distances."""
    low, high = np.float32(scan.range_min), np.float32(scan.range_max)
    usable: NDArray[np.bool_] = np.isfinite(scan.ranges) & (scan.ranges >= low)
    return usable & (scan.ranges <= high)


def _degrees(scan: Scan) -> Floats:
    """Return the beams' angles, -180 ... 180 [degrees]."""
    degrees: Floats = np.degrees((scan.angles + math.pi) % math.tau - math.pi)
    return degrees


def _points(scan: Scan, mask: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Return x (ahead) and y (left) of the chosen readings [m]."""
    ranges, angles = scan.ranges[mask].astype(float), scan.angles[mask]
    return ranges * np.cos(angles), ranges * np.sin(angles)


def _metres(value: float) -> str:
    return "blind" if math.isnan(value) else f"{value:.2f} m"
