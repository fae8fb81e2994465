"""From a scenario to a layout: place the clutter, then mirror and rotate everything."""

import math

import numpy as np

from sim.clearance import clearance, is_inside
from sim.errors import InputError
from sim.faults import sensor_rng
from sim.layout import Cart, Floats, Layout, Pose
from sim.scenario import Scenario, yaw_in_radians
from sim.world import Clutter, MovingCart, Pillar, Point, World

PILLAR_SIDES = 16
START_ROOM = 0.5  # free space between the robot's edge and clutter at the start [m]
_TRIES = 1000  # at a free place for one clutter box


def scenario_layout(scenario: Scenario, seed: int) -> Layout:
    """Return the layout of a scenario with this seed: where everything stands, nothing simulated.

    Raises InputError: the robot's start is not free, or the clutter does not fit.
    """
    spec = scenario.robot
    jitter = sensor_rng(seed, "start").uniform(-1, 1, 3) * yaw_in_radians(spec.start_jitter)
    x, y, yaw = (jitter + yaw_in_radians(spec.start)).tolist()
    layout = build_layout(
        scenario.world,
        start=(x, y, yaw),
        radius=spec.radius,
        rng=sensor_rng(seed, "clutter"),
        mirror=scenario.mirror,
        rotate_deg=scenario.rotate_deg,
    )
    x, y, _ = layout.start
    free = clearance(layout, np.zeros(1), np.array([[x, y]]), spec.radius)[0]
    if free <= 0.0 or is_inside(layout, (x, y)):
        raise InputError(
            f"{scenario.name or scenario.title}: robot.start: the robot would stand in something "
            f"at ({x:.3g}, {y:.3g}); expected a free place of radius {spec.radius}"
        )
    return layout


def build_layout(
    world: World,
    *,
    start: Pose = (0.0, 0.0, 0.0),
    radius: float = 0.17,
    rng: np.random.Generator | None = None,
    mirror: bool = False,
    rotate_deg: float = 0.0,
) -> Layout:
    """Return a world with its clutter placed, mirrored (y → -y), and rotated about the origin.

    Raises InputError: the clutter does not fit into its area.

    Parameters
    ----------
    start
        The robot's pose before mirroring and rotating [m, m, rad].
    radius
        The robot's radius [m]; clutter stays `START_ROOM` away from its edge.
    rng
        Draws the clutter.
    """
    rng = np.random.default_rng(0) if rng is None else rng
    solids = [_box(b.center, b.size, math.radians(b.yaw_deg)) for b in world.boxes]
    solids += [_pillar(p) for p in world.pillars]
    room = (start[0], start[1], radius + START_ROOM)
    for index, clutter in enumerate(world.clutter):
        solids += _scatter(clutter, room, rng, index)
    x, y, yaw = place(start, mirror=mirror, rotate_deg=rotate_deg)
    matrix = _matrix(mirror, rotate_deg)
    return Layout(
        walls=tuple(np.array(w.outline(), float) @ matrix.T for w in world.walls),
        solids=tuple(_turned(solid, matrix, mirror) for solid in solids),
        carts=tuple(_cart(c, matrix) for c in world.carts),
        start=(x, y, yaw),
    )


def place(pose: Pose, *, mirror: bool = False, rotate_deg: float = 0.0) -> Pose:
    """Return a pose [m, m, rad] mirrored (y → -y), then rotated about the origin.

    A pose that is not finite stays as it is.
    """
    x, y, yaw = pose
    if not all(map(math.isfinite, pose)) or not (mirror or rotate_deg):
        return pose
    px, py = _matrix(mirror, rotate_deg) @ (x, y)
    yaw = (-yaw if mirror else yaw) + math.radians(rotate_deg)
    return float(px), float(py), math.remainder(yaw, math.tau)


def _matrix(mirror: bool, rotate_deg: float) -> Floats:
    c, s = _cos_sin(rotate_deg)
    flip = -1.0 if mirror else 1.0
    return np.array([[c, -s * flip], [s, c * flip]])


def _cos_sin(degrees: float) -> tuple[float, float]:
    """Return cos and sin; exact for quarter turns, which keep a world on its grid."""
    quarters, rest = divmod(degrees, 90.0)
    if rest == 0.0:
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarters) % 4]
    return math.cos(math.radians(degrees)), math.sin(math.radians(degrees))


def _turned(polygon: Floats, matrix: Floats, mirror: bool) -> Floats:
    """Return the polygon placed, counter-clockwise again although mirroring reverses it."""
    placed: Floats = polygon @ matrix.T
    return placed[::-1].copy() if mirror else placed


def _cart(cart: MovingCart, matrix: Floats) -> Cart:
    path = np.array(cart.path, float)
    path[:, 1:] = path[:, 1:] @ matrix.T
    return Cart(_box((0.0, 0.0), cart.size, 0.0), path, cart.loop)


def _box(center: Point, size: tuple[float, float], yaw: float) -> Floats:
    w, h = size[0] / 2, size[1] / 2
    c, s = math.cos(yaw), math.sin(yaw)
    corners = np.array([[-w, -h], [w, -h], [w, h], [-w, h]])
    placed: Floats = corners @ np.array([[c, s], [-s, c]]) + np.array(center)
    return placed


def _pillar(pillar: Pillar) -> Floats:
    angles = np.arange(PILLAR_SIDES) * (math.tau / PILLAR_SIDES)
    circle = np.column_stack((np.cos(angles), np.sin(angles)))
    placed: Floats = pillar.radius * circle + np.array(pillar.center)
    return placed


def _scatter(
    clutter: Clutter, room: tuple[float, float, float], rng: np.random.Generator, index: int
) -> list[Floats]:
    circles = np.array([room, *clutter.keep_clear])
    boxes: list[Floats] = []
    for _ in range(clutter.count * _TRIES):
        if len(boxes) == clutter.count:
            break
        box = _random_box(clutter, rng)
        if _keeps_clear(box, circles):
            boxes.append(box)
    if len(boxes) < clutter.count:
        raise InputError(
            f"clutter[{index}]: only {len(boxes)} of {clutter.count} boxes fit: "
            "make the area larger, or keep less of it clear (the robot's start is kept clear too)"
        )
    return boxes


def _random_box(clutter: Clutter, rng: np.random.Generator) -> Floats:
    x, y = rng.uniform(*clutter.area)
    width, height = rng.uniform(*clutter.size, 2)
    return _box((x, y), (width, height), rng.uniform(0.0, math.pi))


def _keeps_clear(box: Floats, circles: Floats) -> bool:
    """Say whether the circle around a box stays outside all circles (x, y, radius)."""
    center = box.mean(axis=0)
    reach = math.dist(box[0], center)
    gaps = np.hypot(*(circles[:, :2] - center).T) - circles[:, 2] - reach
    return bool(gaps.min() >= 0.0)
