"""The robot and what it can run into: a differential drive in pymunk.

The drive is a kinematic companion body that moves as the wheels would; a pivot and a gear joint
pull the robot along with limited force. So contacts win: the robot stops at a wall; if its velocity
were assigned, it would be pushed through. Nothing corrects the companion's lead (`max_bias` 0), so
a robot that was held does not jump when it comes free.

The wheels' speed ramps from the robot's *actual* speed within the acceleration limit: a robot that
is held at a wall can back away at once.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import pymunk

# What pymunk's properties do around these calls was a third of a step.
from pymunk._chipmunk_cffi import lib as chipmunk

from sim.layout import Cart, Layout, Pose
from sim.scenario import RobotSpec

STEP_NS = 10_000_000  # [ns]
STEP = STEP_NS / 1e9  # [s]
COLLISION_SLOP = 0.001  # overlap that contacts keep [m]; pymunk's 0.1 is over half our radius
MASS = 4.0  # [kg], about a TurtleBot 4
_GRIP = 60.0  # limit of the pivot's force [N]: ample for 0.9 m/s², too weak to push through a wall
_TWIST_GRIP = 20.0  # limit of the gear's torque [Nm]
_FRICTION = 0.4
_ROBOT = 1  # collision type


class Robot:
    """The robot among walls, solids and carts; `step` advances everything by 10 ms.

    Parameters
    ----------
    spec
        Radius and limits.
    layout
        Obstacles, and where the robot starts.
    """

    def __init__(self, spec: RobotSpec, layout: Layout) -> None:
        self.pose: Pose = layout.start  # [m, m, rad]
        self.v = 0.0  # forward speed [m/s]
        self.w = 0.0  # turning speed [rad/s]
        self.touched = False  # in contact during the last step
        self._spec = spec
        self._space = pymunk.Space()
        self._space.collision_slop = COLLISION_SLOP
        self._add_static(layout)
        self._carts = [(cart, self._add_cart(cart)) for cart in layout.carts]
        self._body, self._wheels = self._add_robot(layout.start)
        self._space.on_collision(_ROBOT, None, pre_solve=self._touch)

    def step(self, start: float, linear: float, angular: float) -> None:
        """Advance by `STEP` from scenario time `start` [s] with these wheel speeds [m/s, rad/s]."""
        spec = self._spec
        v = _toward(linear, spec.max_linear, self.v, spec.max_acceleration * STEP)
        w = _toward(angular, spec.max_angular, self.w, spec.max_angular_acceleration * STEP)
        # pymunk moves the bodies by their old velocities and then sets the new ones, which move
        # them in the next step: this is the mean heading of that step.
        heading = self.pose[2] + STEP * (self.w + 0.5 * w)
        cos, sin = math.cos(heading), math.sin(heading)
        chipmunk.cpBodySetVelocity(self._wheels._body, (v * cos, v * sin))
        chipmunk.cpBodySetAngularVelocity(self._wheels._body, w)
        for cart, body in self._carts:
            _drive(cart, body, start)
        self.touched = False
        chipmunk.cpSpaceStep(self._space._space, STEP)
        self._read(cos, sin)

    def teleport(self, pose: Pose) -> None:
        """Put the robot at a pose [m, m, rad], at rest."""
        self.pose, self.v, self.w = pose, 0.0, 0.0
        self._body.position = pose[:2]
        self._body.angle = pose[2]
        self._body.velocity = 0.0, 0.0
        self._body.angular_velocity = 0.0

    def _read(self, cos: float, sin: float) -> None:
        body = self._body._body
        place, velocity = chipmunk.cpBodyGetPosition(body), chipmunk.cpBodyGetVelocity(body)
        self.pose = place.x, place.y, chipmunk.cpBodyGetAngle(body)
        self.v = velocity.x * cos + velocity.y * sin
        self.w = chipmunk.cpBodyGetAngularVelocity(body)

    def _touch(self, arbiter: Any, space: Any, data: Any) -> None:
        self.touched = True

    def _add_static(self, layout: Layout) -> None:
        ground = self._space.static_body
        shapes: list[pymunk.Shape] = [
            pymunk.Poly(ground, _points(polygon)) for polygon in layout.solids
        ]
        for wall in layout.walls:
            pairs = pairwise(_points(wall))
            shapes += [pymunk.Segment(ground, a, b, 0.0) for a, b in pairs]
        for shape in shapes:
            shape.friction = _FRICTION
        self._space.add(*shapes)

    def _add_cart(self, cart: Cart) -> pymunk.Body:
        body = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        shape = pymunk.Poly(body, _points(cart.polygon))
        shape.friction = _FRICTION
        self._space.add(body, shape)
        _drive(cart, body, 0.0)
        return body

    def _add_robot(self, start: Pose) -> tuple[pymunk.Body, pymunk.Body]:
        radius = self._spec.radius
        body = pymunk.Body(MASS, pymunk.moment_for_circle(MASS, 0.0, radius))
        shape = pymunk.Circle(body, radius)
        shape.friction = _FRICTION
        shape.collision_type = _ROBOT
        wheels = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        for part in (body, wheels):
            part.position = start[:2]
            part.angle = start[2]
        pivot = pymunk.PivotJoint(wheels, body, (0.0, 0.0), (0.0, 0.0))
        gear = pymunk.GearJoint(wheels, body, 0.0, 1.0)
        pivot.max_force, gear.max_force = _GRIP, _TWIST_GRIP
        pivot.max_bias = gear.max_bias = 0.0
        self._space.add(body, shape, wheels, pivot, gear)
        return body, wheels


def _toward(target: float, limit: float, now: float, change: float) -> float:
    """Return `target` within ±limit, but at most `change` away from `now`."""
    target = limit if target > limit else -limit if target < -limit else target
    low, high = now - change, now + change
    return high if target > high else low if target < low else target


def _drive(cart: Cart, body: pymunk.Body, start: float) -> None:
    """Put a cart where it is at `start` [s], moving to where it is one step later."""
    (x, y, yaw), (next_x, next_y, _) = cart.pose(start), cart.pose(start + STEP)
    chipmunk.cpBodySetPosition(body._body, (x, y))
    chipmunk.cpBodySetAngle(body._body, yaw)
    chipmunk.cpBodySetVelocity(body._body, ((next_x - x) / STEP, (next_y - y) / STEP))


def _points(points: Any) -> Sequence[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in points]
