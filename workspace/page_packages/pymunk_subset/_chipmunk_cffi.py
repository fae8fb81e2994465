"""The calls of the library below pymunk that sim.robot makes: bodies here are their own."""

from operator import attrgetter
from types import SimpleNamespace

lib = SimpleNamespace(
    cpBodyGetPosition=lambda body: body,  # it has x and y
    cpBodyGetVelocity=lambda body: SimpleNamespace(x=body.vx, y=body.vy),
    cpBodyGetAngle=attrgetter("angle"),
    cpBodyGetAngularVelocity=attrgetter("angular_velocity"),
    cpBodySetPosition=lambda body, place: setattr(body, "position", place),
    cpBodySetVelocity=lambda body, velocity: setattr(body, "velocity", velocity),
    cpBodySetAngle=lambda body, angle: setattr(body, "angle", angle),
    cpBodySetAngularVelocity=lambda body, speed: setattr(body, "angular_velocity", speed),
    cpSpaceStep=lambda space, dt: space.step(dt),
)
