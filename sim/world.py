"""World files: what stands in a world, before a seed and a scenario place it.

A world file is TOML, in metres and radians (keys that end in `_deg` are degrees)::

    description = "A room with a cart"
    [[walls]]                       # a thin polyline, seen and hit from both sides
    points = [[-6, -4], [6, -4], [6, 4], [-6, 4]]
    closed = true
    [[boxes]]                       # solid
    center = [2, 0]
    size = [0.5, 1.0]
    yaw_deg = 30
    [[pillars]]                     # solid, a regular 16-gon
    center = [0, 2]
    radius = 0.15
    [[clutter]]                     # boxes placed by the seed, never at the robot's start
    area = [[1, -3], [5, 3]]
    count = 12
    size = [0.2, 0.6]               # shortest and longest side
    keep_clear = [[0, 0, 1.0]]      # x, y, radius
    [[carts]]                       # a moving solid box
    size = [0.6, 0.4]
    path = [[0, 3, -3], [6, 3, 3]]  # time [s], x, y
    loop = false
"""

import math
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import msgspec
from msgspec import Meta

from sim.errors import InputError
from sim.toml_input import Key, convert, nearest, parse_toml, read_toml

WORLDS = Path(__file__).parent / "worlds"

Metres = Annotated[float, Meta(ge=-1000, le=1000)]
Size = Annotated[float, Meta(ge=0.001, le=1000)]
Degrees = Annotated[float, Meta(ge=-3600, le=3600)]
Seconds = Annotated[float, Meta(ge=0, le=3600)]
Count = Annotated[int, Meta(ge=0, le=2000)]
Point = tuple[Metres, Metres]

LEAST = 0.001  # length of a segment [m]: the lidar's resolution
MAX_OBSTACLES = 2000  # walls' segments, boxes, pillars, clutter and carts together
MAX_CART_SPEED = 2.0  # [m/s]; a faster one could jump through a robot in one physics step


class _Table(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    pass


class Wall(_Table, frozen=True):
    """A thin polyline."""

    points: Annotated[tuple[Point, ...], Meta(min_length=2, max_length=MAX_OBSTACLES)]  # [m]
    closed: bool = False

    def __post_init__(self) -> None:
        """Refuse a wall with a segment of no length."""
        if any(math.dist(a, b) < LEAST for a, b in pairwise(self.outline())):
            raise ValueError(f"points: expected each at least {LEAST} m from the one before")

    def outline(self) -> tuple[Point, ...]:
        """Return the points, with the first one again at the end of a closed wall."""
        return (*self.points, self.points[0]) if self.closed else self.points


class Box(_Table, frozen=True):
    """A solid box."""

    center: Point  # [m]
    size: tuple[Size, Size]  # along its own x and y [m]
    yaw_deg: Degrees = 0.0


class Pillar(_Table, frozen=True):
    """A solid pillar."""

    center: Point  # [m]
    radius: Size = 0.15  # of the circle through its corners [m]


class Clutter(_Table, frozen=True):
    """Boxes that the seed scatters over an area."""

    area: tuple[Point, Point]  # two opposite corners; the boxes' centres lie in it [m]
    count: Count
    size: tuple[Size, Size] = (0.2, 0.6)  # shortest and longest side [m]
    keep_clear: tuple[tuple[Metres, Metres, Size], ...] = ()  # circles: x, y, radius [m]

    def __post_init__(self) -> None:
        """Refuse an area or a size whose limits are swapped."""
        (x0, y0), (x1, y1) = self.area
        if not (x0 < x1 and y0 < y1):
            raise ValueError("area: expected [[x0, y0], [x1, y1]] with x0 < x1 and y0 < y1")
        if self.size[0] > self.size[1]:
            raise ValueError("size: expected [shortest, longest]")


class MovingCart(_Table, frozen=True):
    """A solid box that moves along waypoints."""

    size: tuple[Size, Size]  # along and across its motion [m]
    path: Annotated[tuple[tuple[Seconds, Metres, Metres], ...], Meta(min_length=1, max_length=1000)]
    loop: bool = False

    def __post_init__(self) -> None:
        """Refuse paths that no cart could drive."""
        for (t0, x0, y0), (t1, x1, y1) in pairwise(self.path):
            if t1 <= t0:
                raise ValueError(f"path: expected increasing times, got {t1} after {t0}")
            speed = math.hypot(x1 - x0, y1 - y0) / (t1 - t0)
            if speed > MAX_CART_SPEED:
                raise ValueError(
                    f"path: expected at most {MAX_CART_SPEED} m/s, got {speed:.3g} m/s at {t0} s"
                )
        if self.loop and self.path[0][1:] != self.path[-1][1:]:
            raise ValueError("path: expected a loop to end where it begins")


class World(_Table, frozen=True):
    """What stands in a world, as its file describes it."""

    description: str = ""
    walls: tuple[Wall, ...] = ()
    boxes: tuple[Box, ...] = ()
    pillars: tuple[Pillar, ...] = ()
    clutter: tuple[Clutter, ...] = ()
    carts: tuple[MovingCart, ...] = ()

    def __post_init__(self) -> None:
        """Refuse a world that would take forever."""
        count = sum(len(w.outline()) - 1 for w in self.walls) + sum(c.count for c in self.clutter)
        count += len(self.boxes) + len(self.pillars) + len(self.carts)
        if count > MAX_OBSTACLES:
            raise ValueError(f"expected at most {MAX_OBSTACLES} obstacles in a world, got {count}")


def world_names() -> dict[str, Path]:
    """Return the worlds that come with the course: name → file, sorted by name."""
    return {path.stem: path for path in sorted(WORLDS.glob("*.toml"))}


@lru_cache(maxsize=64)
def load_world(name: str) -> World:
    """Return the world of that name.

    Raises InputError: there is no such world, or its file is wrong.
    """
    names = world_names()
    if name not in names:
        raise InputError(f"no world is called '{name}'{nearest(name, names)}")
    path = names[name]
    return world_from_doc(parse_toml(read_toml(path), str(path)), str(path))


def world_from_doc(doc: Any, where: str, *, at: Key = ()) -> World:
    """Return the world in a parsed table; `where` and `at` say in errors where it stands."""
    return convert(doc, World, where, at=at)
