"""What sim.robot uses of pymunk: one moving circle among fixed and driven shapes.

The step is Chipmunk's (cpSpaceStep, cpArbiter, cpPivotJoint, cpGearJoint, version 7), of which
there is no build for the page's Python: positions, contacts, impulses kept from the step before,
then ten iterations over contacts and joints. Shapes of no radius, collisions of the circle only.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

Point = tuple[float, float]


class Body:
    """A body; only a dynamic one has a mass, and yields."""

    DYNAMIC, KINEMATIC, STATIC = range(3)

    def __init__(self, mass: float = 0.0, moment: float = 0.0, body_type: int = DYNAMIC) -> None:
        self.body_type, self._body = body_type, self
        dynamic = body_type == Body.DYNAMIC
        self.inverse_mass, self.inverse_moment = (1 / mass, 1 / moment) if dynamic else (0.0, 0.0)
        self.x = self.y = self.angle = 0.0
        self.vx = self.vy = self.angular_velocity = 0.0
        self.bias_x = self.bias_y = self.bias_w = 0.0  # what pushes overlapping bodies apart

    @property
    def position(self) -> Point:
        """[m]."""
        return self.x, self.y

    @position.setter
    def position(self, place: Point) -> None:
        self.x, self.y = place

    @property
    def velocity(self) -> Point:
        """[m/s]."""
        return self.vx, self.vy

    @velocity.setter
    def velocity(self, velocity: Point) -> None:
        self.vx, self.vy = velocity

    def advance(self, dt: float) -> None:
        """Move for a step [s]."""
        self.x += (self.vx + self.bias_x) * dt
        self.y += (self.vy + self.bias_y) * dt
        self.angle += (self.angular_velocity + self.bias_w) * dt
        self.bias_x = self.bias_y = self.bias_w = 0.0

    def push(self, x: float, y: float, turn: float) -> None:
        """Take an impulse [N s] and its moment."""
        self.vx += x * self.inverse_mass
        self.vy += y * self.inverse_mass
        self.angular_velocity += turn * self.inverse_moment


class Shape:
    """The outline of a body, in its own frame."""

    friction = 0.0
    collision_type = 0

    def __init__(self, body: Body, points: Sequence[Point] = (), *, closed: bool = False) -> None:
        self.body, self.points, self.closed = body, points, closed


class Circle(Shape):
    """A disc around its body."""

    def __init__(self, body: Body, radius: float) -> None:
        super().__init__(body)
        self.radius = radius


class Segment(Shape):
    """A line without a width."""

    def __init__(self, body: Body, a: Point, b: Point, radius: float) -> None:
        super().__init__(body, (a, b))


class Poly(Shape):
    """The convex hull of points."""

    def __init__(self, body: Body, points: Sequence[Point]) -> None:
        ordered = sorted(set(points))
        hull = [*_half_hull(ordered), *_half_hull(ordered[::-1])]
        super().__init__(body, hull, closed=True)


def _half_hull(points: Sequence[Point]) -> list[Point]:
    kept: list[Point] = []
    for point in points:
        while len(kept) > 1 and _turn(kept[-2], kept[-1], point) <= 0:
            kept.pop()
        kept.append(point)
    return kept[:-1]


def _turn(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


class PivotJoint:
    """Pulls the second body to the first one's velocity, with a limited force."""

    max_force = max_bias = math.inf

    def __init__(self, a: Body, b: Body, anchor_a: Point, anchor_b: Point) -> None:
        self.a, self.b = a, b
        self.x = self.y = 0.0  # [N s]

    def keep(self, share: float) -> None:
        """Begin with a share of the impulse of the step before."""
        self.b.push(self.x * share, self.y * share, 0.0)

    def solve(self, dt: float) -> None:
        """Come nearer to the impulse that is right."""
        a, b, most = self.a, self.b, self.max_force * dt
        mass = 1 / (a.inverse_mass + b.inverse_mass)
        x, y = self.x - (b.vx - a.vx) * mass, self.y - (b.vy - a.vy) * mass
        size = math.sqrt(x * x + y * y)
        if size > most:
            x, y = x * (most / size), y * (most / size)
        b.push(x - self.x, y - self.y, 0.0)
        self.x, self.y = x, y


class GearJoint:
    """Turns the second body as fast as the first, with a limited moment."""

    max_force = max_bias = math.inf

    def __init__(self, a: Body, b: Body, phase: float, ratio: float) -> None:
        self.a, self.b = a, b
        self.turn = 0.0  # [N m s]

    def keep(self, share: float) -> None:
        """Begin with a share of the impulse of the step before."""
        self.b.push(0.0, 0.0, self.turn * share)

    def solve(self, dt: float) -> None:
        """Come nearer to the impulse that is right."""
        a, b, most = self.a, self.b, self.max_force * dt
        moment = 1 / (a.inverse_moment + b.inverse_moment)
        turn = self.turn - (b.angular_velocity - a.angular_velocity) * moment
        turn = min(max(turn, -most), most)
        b.push(0.0, 0.0, turn - self.turn)
        self.turn = turn


class _Contact:
    """The circle touches a shape: at one point, with impulses along and across."""

    NEW, LASTING, OVER = range(3)

    def __init__(self, circle: Circle, shape: Shape) -> None:
        self.body, self.other = circle.body, shape.body
        self.friction = circle.friction * shape.friction
        self.state, self.stamp = _Contact.NEW, 0
        self.along = self.across = 0.0  # [N s]

    def meet(self, stamp: int, normal: Point, mine: Point, theirs: Point) -> None:
        """Touch at these points of the two, in this direction from the circle."""
        if self.state == _Contact.OVER:
            self.state = _Contact.NEW
        self.stamp, self.normal = stamp, normal
        body, other = self.body, self.other
        self.mine = mine[0] - body.x, mine[1] - body.y
        self.theirs = theirs[0] - other.x, theirs[1] - other.y

    def prepare(self, dt: float, slop: float, share: float) -> None:
        """Find out how hard it is to push, and how far the two overlap."""
        (nx, ny), (mx, my), (tx, ty), body = self.normal, self.mine, self.theirs, self.body
        self.mass = 1 / (body.inverse_mass + body.inverse_moment * (mx * ny - my * nx) ** 2)
        self.side = 1 / (body.inverse_mass + body.inverse_moment * (mx * nx + my * ny) ** 2)
        gap = (tx - mx + self.other.x - body.x) * nx + (ty - my + self.other.y - body.y) * ny
        self.bias, self.pushed = -share * min(0.0, gap + slop) / dt, 0.0

    def push(self, along: float, across: float) -> None:
        """Push the circle away, and along the shape [N s]."""
        (nx, ny), (mx, my) = self.normal, self.mine
        x, y = nx * along - ny * across, ny * along + nx * across
        self.body.push(-x, -y, -(mx * y - my * x))

    def solve(self) -> None:
        """Come nearer to the impulses that are right."""
        (nx, ny), (mx, my), (tx, ty) = self.normal, self.mine, self.theirs
        body, other = self.body, self.other
        bias_x = (other.bias_x - ty * other.bias_w) - (body.bias_x - my * body.bias_w)
        bias_y = (other.bias_y + tx * other.bias_w) - (body.bias_y + mx * body.bias_w)
        vx = (other.vx - ty * other.angular_velocity) - (body.vx - my * body.angular_velocity)
        vy = (other.vy + tx * other.angular_velocity) - (body.vy + mx * body.angular_velocity)
        pushed, along, across = self.pushed, self.along, self.across
        self.pushed = max(pushed + (self.bias - (bias_x * nx + bias_y * ny)) * self.mass, 0.0)
        self.along = max(along - (vx * nx + vy * ny) * self.mass, 0.0)
        most = self.friction * self.along
        self.across = min(max(across - (vy * nx - vx * ny) * self.side, -most), most)
        apart = self.pushed - pushed
        body.bias_x -= nx * apart * body.inverse_mass
        body.bias_y -= ny * apart * body.inverse_mass
        body.bias_w -= body.inverse_moment * (mx * ny * apart - my * nx * apart)
        self.push(self.along - along, self.across - across)


class Space:
    """All bodies, shapes and joints."""

    collision_slop, collision_bias, collision_persistence = 0.1, (1 - 0.1) ** 60, 3
    iterations = 10

    def __init__(self) -> None:
        self.static_body, self._space = Body(body_type=Body.STATIC), self
        self._bodies: list[Body] = []
        self._fixed: list[tuple[float, float, float, float, Shape]] = []  # with what is around it
        self._driven: list[Shape] = []
        self._circle: Circle
        self._joints: list[PivotJoint | GearJoint] = []
        self._touch: Callable[..., None] = lambda *_: None
        self._contacts: dict[int, _Contact] = {}
        self._stamp, self._last = 0, 0.0

    def add(self, *parts: Body | Shape | PivotJoint | GearJoint) -> None:
        """Add parts."""
        for part in parts:
            if isinstance(part, Body):
                self._bodies.append(part)
            elif isinstance(part, Circle):
                self._circle = part
            elif not isinstance(part, Shape):
                self._joints.append(part)
            elif part.body.body_type == Body.STATIC:
                xs, ys = zip(*part.points, strict=True)
                self._fixed.append((min(xs), min(ys), max(xs), max(ys), part))
            else:
                self._driven.append(part)

    def on_collision(self, a: Any, b: Any, *, pre_solve: Callable[..., None]) -> None:
        """Call this in each step in which the circle touches anything."""
        self._touch = pre_solve

    def step(self, dt: float) -> None:
        """Advance [s]."""
        self._stamp += 1
        share, self._last = (dt / self._last if self._last else 0.0), dt
        for contact in self._contacts.values():
            if contact.state == _Contact.NEW:
                contact.state = _Contact.LASTING
        for body in self._bodies:
            body.advance(dt)
        touching = self._collide()
        overlap = 1 - self.collision_bias**dt
        for contact in touching:
            contact.prepare(dt, self.collision_slop, overlap)
        for contact in touching:
            if contact.state != _Contact.NEW:
                contact.push(contact.along * share, contact.across * share)
        for joint in self._joints:
            joint.keep(share)
        for _ in range(self.iterations):
            for contact in touching:
                contact.solve()
            for joint in self._joints:
                joint.solve(dt)

    def _collide(self) -> list[_Contact]:
        body, r = self._circle.body, self._circle.radius
        x, y = body.x, body.y
        near = [
            shape
            for left, low, right, high, shape in self._fixed
            if left - r <= x <= right + r and low - r <= y <= high + r
        ]
        found = [contact for shape in (*near, *self._driven) if (contact := self._meet(shape))]
        for key, contact in list(self._contacts.items()):
            age = self._stamp - contact.stamp
            if age >= 1:
                contact.state = _Contact.OVER
            if age >= self.collision_persistence:
                del self._contacts[key]
        return found

    def _meet(self, shape: Shape) -> _Contact | None:
        """Return the contact of the circle with a shape; None if it touches nothing there."""
        circle, other = self._circle, shape.body
        x, y, radius = circle.body.x, circle.body.y, circle.radius
        cos, sin = math.cos(other.angle), math.sin(other.angle)
        dx, dy = x - other.x, y - other.y
        here = (dx * cos + dy * sin, dy * cos - dx * sin)
        if other.body_type == Body.STATIC:
            here = x, y
        square, (px, py), inside = _nearest(shape, here)
        if square >= radius * radius and not inside:
            return None
        if other.body_type != Body.STATIC:
            px, py = other.x + px * cos - py * sin, other.y + px * sin + py * cos
        distance = math.sqrt(square) * (-1 if inside else 1)
        normal = ((px - x) / distance, (py - y) / distance) if distance else (1.0, 0.0)
        contact = self._contacts.setdefault(id(shape), _Contact(circle, shape))
        mine = x + normal[0] * radius, y + normal[1] * radius
        contact.meet(self._stamp, normal, mine, (px, py))
        self._touch(None, self, None)
        return contact


def _nearest(shape: Shape, here: Point) -> tuple[float, Point, bool]:
    """Return the square of the distance to the nearest point of an outline, it, and if inside."""
    x, y = here
    points, inside = shape.points, shape.closed
    found, point = math.inf, here
    ends = [*points[1:], points[0]] if shape.closed else points[1:]
    for (ax, ay), (bx, by) in zip(points, ends, strict=False):
        ex, ey = bx - ax, by - ay
        if shape.closed and ex * (y - ay) - ey * (x - ax) < 0:
            inside = False
        length = ex * ex + ey * ey
        part = min(max((ex * (x - ax) + ey * (y - ay)) / length, 0.0), 1.0) if length else 0.0
        cx, cy = ax + ex * part, ay + ey * part
        square = (cx - x) ** 2 + (cy - y) ** 2
        if square < found:
            found, point = square, (cx, cy)
    return found, point, inside


def moment_for_circle(mass: float, inner: float, outer: float, offset: Point = (0, 0)) -> float:
    """Return the moment of inertia of a disc [kg m²]."""
    return mass * 0.5 * (inner * inner + outer * outer)
