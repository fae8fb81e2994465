"""The scene for Foxglove: a web socket on loopback with walls, robot, scans and commands.

Frame `map` is the true world, with `base_link` at the robot's true pose. `odom`, in which the
odometry is shown, coincides with `map`: so a robot that drifts is seen beside its odometry.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from sim.errors import InputError
from sim.layout import Floats, Layout, Pose
from sim.messages import BASE_FRAME, LASER_SCAN, ODOM_FRAME, ODOMETRY, Message, decode, half_angle
from sim.scenario import LidarSpec

HOST = "127.0.0.1"
PORT = 8765  # Foxglove's own default
MAP_FRAME = "map"
HOW_TO_INSTALL = "--foxglove needs the Foxglove SDK: pip install '.[foxglove]'"
SCENE_EVERY = 10**9  # [ns]; how long a viewer that connects later waits for the walls
HEIGHT = 0.3  # of every obstacle [m]
WALL = 0.03  # thickness of a wall's line [m]
NUMBER = {"type": ["number", "null"]}  # null: not finite
COMMAND = {  # JSON schema of what was heard on /cmd_vel [m/s, rad/s]
    "title": "Command",
    "type": "object",
    "properties": {"linear_x": NUMBER, "angular_z": NUMBER},
}
COLOURS = {  # red, green, blue
    "wall": (0.25, 0.25, 0.28),
    "solid": (0.55, 0.5, 0.45),
    "cart": (0.9, 0.5, 0.1),
    "robot": (0.15, 0.45, 0.85),
}


class Viewer:
    """A server that shows one robot.

    Raises InputError: the SDK is not installed, or the port is taken.

    Parameters
    ----------
    name
        The server's.
    port
        The server's; 0: any that is free.
    """

    def __init__(self, name: str, port: int = PORT) -> None:
        try:
            import foxglove  # noqa: PLC0415
            from foxglove import channels, messages  # noqa: PLC0415
        except ImportError:
            raise InputError(HOW_TO_INSTALL) from None
        self._context = context = foxglove.Context()  # its channels close when it is collected
        try:
            self._server = foxglove.start_server(name=name, host=HOST, port=port, context=context)
        except Exception as error:  # the SDK's own exceptions
            raise InputError(f"--foxglove {port}: cannot serve on {HOST}: {error}") from None
        self._kinds = messages
        self._scene = channels.SceneUpdateChannel("/scene", context=context)
        self._frames = channels.FrameTransformsChannel("/transforms", context=context)
        self._scan = channels.LaserScanChannel("/scan", context=context)
        self._odom = channels.PoseInFrameChannel("/odom", context=context)
        self._cmd_vel = foxglove.Channel("/cmd_vel", schema=COMMAND, context=context)
        self._scene_due = 0  # ROS time [ns]

    @property
    def url(self) -> str:
        """Where a viewer finds the server."""
        return f"ws://{HOST}:{self._server.port}"

    def show(
        self,
        messages: Iterable[Message],
        *,
        layout: Layout,
        radius: float,
        lidar: LidarSpec,
        pose: Pose,
        seconds: float,
        time: int,
    ) -> None:
        """Show the world at a moment, and the messages that were sent then.

        Parameters
        ----------
        messages
            Stamped in ROS time.
        layout, radius, lidar
            The world; the robot's radius [m] and its lidar.
        pose
            The robot's true pose [m, m, rad].
        seconds
            Scenario time [s].
        time
            ROS time [ns].
        """
        entities = [*self._carts(layout, seconds)]
        if not 0 <= self._scene_due - time < SCENE_EVERY:
            entities += [*self._standing(layout), self._robot(radius)]
            self._scene_due = time + SCENE_EVERY - 1
        if entities:
            self._scene.log(self._kinds.SceneUpdate(entities=entities), log_time=time)
        self._frames.log(self._transforms(pose, lidar, time), log_time=time)
        for message in messages:
            if message.type == LASER_SCAN and self._scan.has_sinks():
                self._scan.log(self._laser_scan(message.data), log_time=time)
            elif message.type == ODOMETRY and self._odom.has_sinks():
                self._odom.log(self._odometry(message.data), log_time=time)

    def command(self, linear: float, angular: float, time: int) -> None:
        """Show a command that was heard [m/s, rad/s] at a ROS time [ns]."""
        values = {"linear_x": _finite(linear), "angular_z": _finite(angular)}
        self._cmd_vel.log(values, log_time=time)

    def clear(self) -> None:
        """Clear what viewers show: the scenario starts over."""
        self._scene_due = 0
        self._server.clear_session()

    def close(self) -> None:
        """Stop serving."""
        self._server.stop()

    def _standing(self, layout: Layout) -> Iterator[Any]:
        kinds = self._kinds
        if layout.walls:
            lines = [self._line(wall, "wall") for wall in layout.walls]
            yield kinds.SceneEntity(id="walls", frame_id=MAP_FRAME, lines=lines)
        if layout.solids:
            lines = [self._line([*solid, solid[0]], "solid") for solid in layout.solids]
            faces = [self._face(solid) for solid in layout.solids]
            yield kinds.SceneEntity(id="solids", frame_id=MAP_FRAME, lines=lines, triangles=faces)

    def _robot(self, radius: float) -> Any:
        kinds = self._kinds
        size = kinds.Vector3(x=2 * radius, y=2 * radius, z=HEIGHT)
        body = kinds.CylinderPrimitive(
            pose=self._pose(z=HEIGHT / 2),
            size=size,
            bottom_scale=1.0,
            top_scale=1.0,
            color=self._colour("robot", 0.6),
        )
        nose = kinds.ArrowPrimitive(
            pose=self._pose(z=HEIGHT),
            shaft_length=radius,
            shaft_diameter=0.04,
            head_length=0.08,
            head_diameter=0.09,
            color=self._colour("robot"),
        )
        return kinds.SceneEntity(
            id="robot", frame_id=BASE_FRAME, frame_locked=True, cylinders=[body], arrows=[nose]
        )

    def _carts(self, layout: Layout, seconds: float) -> Iterator[Any]:
        kinds = self._kinds
        for index, cart in enumerate(layout.carts):
            x, y, yaw = cart.pose(seconds)
            low, high = cart.polygon.min(axis=0), cart.polygon.max(axis=0)
            width, depth = (high - low).tolist()
            cube = kinds.CubePrimitive(
                pose=self._pose(x, y, HEIGHT / 2, yaw),
                size=kinds.Vector3(x=width, y=depth, z=HEIGHT),
                color=self._colour("cart"),
            )
            yield kinds.SceneEntity(id=f"cart {index}", frame_id=MAP_FRAME, cubes=[cube])

    def _transforms(self, pose: Pose, lidar: LidarSpec, time: int) -> Any:
        kinds = self._kinds
        stamp = kinds.Timestamp(*divmod(time, 10**9))
        tree = (
            (MAP_FRAME, BASE_FRAME, pose),
            (MAP_FRAME, ODOM_FRAME, (0.0, 0.0, 0.0)),
            (BASE_FRAME, lidar.frame, lidar.pose),
        )
        transforms = [
            kinds.FrameTransform(
                timestamp=stamp,
                parent_frame_id=parent,
                child_frame_id=child,
                translation=kinds.Vector3(x=x, y=y),
                rotation=self._rotation(yaw),
            )
            for parent, child, (x, y, yaw) in tree
        ]
        return kinds.FrameTransforms(transforms=transforms)

    def _laser_scan(self, data: bytes) -> Any:
        scan = decode(data, LASER_SCAN)
        return self._kinds.LaserScan(
            timestamp=self._stamp(scan),
            frame_id=scan.header.frame_id,
            pose=self._pose(),
            start_angle=scan.angle_min,
            end_angle=scan.angle_max,
            ranges=scan.ranges.tolist(),
        )

    def _odometry(self, data: bytes) -> Any:
        kinds = self._kinds
        odometry = decode(data, ODOMETRY)
        p, q = odometry.pose.pose.position, odometry.pose.pose.orientation
        pose = kinds.Pose(
            position=kinds.Vector3(x=p.x, y=p.y, z=p.z),
            orientation=kinds.Quaternion(x=q.x, y=q.y, z=q.z, w=q.w),
        )
        return kinds.PoseInFrame(timestamp=self._stamp(odometry), frame_id=ODOM_FRAME, pose=pose)

    def _stamp(self, message: Any) -> Any:
        stamp = message.header.stamp
        return self._kinds.Timestamp(stamp.sec, stamp.nanosec)

    def _line(self, points: Floats | Sequence[Floats], colour: str) -> Any:
        return self._kinds.LinePrimitive(
            points=self._points(points),
            thickness=WALL,
            pose=self._pose(),
            color=self._colour(colour),
        )

    def _face(self, polygon: Floats) -> Any:
        """Return a convex polygon as a fan of triangles."""
        corners = len(polygon)
        indices = [i for k in range(1, corners - 1) for i in (0, k, k + 1)]
        return self._kinds.TriangleListPrimitive(
            points=self._points(polygon),
            indices=indices,
            pose=self._pose(),
            color=self._colour("solid", 0.6),
        )

    def _points(self, points: Floats | Sequence[Floats]) -> list[Any]:
        return [self._kinds.Point3(x=float(x), y=float(y), z=0.0) for x, y in points]

    def _pose(self, x: float = 0.0, y: float = 0.0, z: float = 0.0, yaw: float = 0.0) -> Any:
        position = self._kinds.Vector3(x=x, y=y, z=z)
        return self._kinds.Pose(position=position, orientation=self._rotation(yaw))

    def _rotation(self, yaw: float) -> Any:
        z, w = half_angle(yaw)
        return self._kinds.Quaternion(x=0.0, y=0.0, z=z, w=w)

    def _colour(self, of: str, alpha: float = 1.0) -> Any:
        red, green, blue = COLOURS[of]
        return self._kinds.Color(r=red, g=green, b=blue, a=alpha)


def _finite(value: float) -> float | None:
    """Return a number that JSON can express, None for any other."""
    return value if math.isfinite(value) else None
