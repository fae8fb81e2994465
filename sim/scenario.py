"""Scenarios: a world, a robot in it, its sensors and faults, a script, a seed and a duration.

The keys are the fields of the structs below. A scenario determines everything about a run except
the node: the same scenario and seed give the same run, byte for byte.
"""

import math
from dataclasses import replace
from functools import cached_property
from itertools import chain, repeat
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from sim.bench import BenchScan, Offset
from sim.lidar import PROFILES, LidarProfile
from sim.messages import LASER_FRAME
from sim.toml_input import nearest
from sim.world import Degrees, Metres, World

MAX_BENCH_SCANS = 20_000

Probability = Annotated[float, Meta(ge=0, le=1)]
Delay = Annotated[float, Meta(ge=0, le=10)]  # [s]
Span = tuple[Delay, Delay]  # at least, at most [s]
Noise = Annotated[float, Meta(ge=0, le=10)]  # standard deviation
Limit = Annotated[float, Meta(gt=0, le=100)]  # of a lidar's readings [m]
Mount = Annotated[float, Meta(ge=-0.5, le=0.5)]  # from the robot's middle [m]
Rate = Annotated[float, Meta(gt=0, le=200)]  # [Hz]
Time = Annotated[float, Meta(gt=0, le=3600)]  # since the scenario's start [s]
Scale = Annotated[float, Meta(gt=0, le=10)]
Interval = tuple[Annotated[float, Meta(ge=0, le=3600)], Annotated[float, Meta(ge=0, le=3600)]]
PoseDeg = tuple[float, float, float]  # x [m], y [m], yaw [°]


class _Table(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    pass


class RobotSpec(_Table, frozen=True):
    """[robot] The defaults are those of a TurtleBot 4 (Create 3 base)."""

    start: tuple[Metres, Metres, Degrees] = (0.0, 0.0, 0.0)  # x [m], y [m], yaw [°]
    start_jitter: tuple[
        Annotated[float, Meta(ge=0, le=100)],
        Annotated[float, Meta(ge=0, le=100)],
        Annotated[float, Meta(ge=0, le=180)],
    ] = (0.0, 0.0, 0.0)  # uniform ±, drawn by the seed
    radius: Annotated[float, Meta(ge=0.05, le=1)] = 0.17  # [m]
    max_linear: Annotated[float, Meta(gt=0, le=2)] = 0.5  # [m/s]
    max_angular: Annotated[float, Meta(gt=0, le=10)] = 1.9  # [rad/s]
    max_acceleration: Annotated[float, Meta(gt=0, le=20)] = 0.9  # [m/s²]
    max_angular_acceleration: Annotated[float, Meta(gt=0, le=100)] = 7.0  # [rad/s²]
    command_timeout: Annotated[float, Meta(gt=0, le=3600)] = 0.5  # [s]; then it comes to a stop


ROBOTS: dict[str, dict[str, float]] = {  # by `[robot] name`: where they differ from `RobotSpec`
    "turtlebot4": {},
    # Speeds: ROBOTIS' e-manual; the rest: its turtlebot3_navigation2/param/burger.yaml
    "turtlebot3_burger": {
        "radius": 0.105,
        "max_linear": 0.22,
        "max_angular": 2.84,
        "max_acceleration": 2.5,
        "max_angular_acceleration": 3.2,
    },
}


class LidarSpec(_Table, frozen=True):
    """[lidar] The sensor behind /scan."""

    profile: str = "default"  # a key of sim.lidar.PROFILES
    enabled: bool = True
    rate: Rate | None = None  # [Hz]; None: the profile's
    limits: tuple[Limit, Limit] | None = None  # range_min, range_max [m]; None: the profile's
    phase: Time = 0.013  # time of the first scan [s]
    mount: tuple[Mount, Mount, Degrees] = (0.0, 0.0, 0.0)  # x [m], y [m], yaw [°] on the robot
    frame: Annotated[str, Meta(pattern=r"^\w+$")] = LASER_FRAME  # `frame_id` of its scans

    @property
    def measures(self) -> LidarProfile:
        """What it measures: the profile, with the limits given here."""
        profile = PROFILES[self.profile]
        if self.limits is None:
            return profile
        return replace(profile, range_min=self.limits[0], range_max=self.limits[1])

    @property
    def pose(self) -> tuple[float, float, float]:
        """Where it is on the robot [m, m, rad]."""
        return yaw_in_radians(self.mount)

    def __post_init__(self) -> None:
        """Refuse an unknown profile."""
        if self.profile not in PROFILES:
            hint = nearest(self.profile, PROFILES)
            raise ValueError(f"profile: no lidar profile is called that{hint}")
        if self.limits is not None and self.limits[0] >= self.limits[1]:
            raise ValueError("limits: expected range_min below range_max")


class OdometrySpec(_Table, frozen=True):
    """[odometry] The sensor behind /odom."""

    enabled: bool = True
    rate: Rate = 20.0  # [Hz]
    phase: Time = 0.007  # time of the first message [s]
    linear_scale: Scale = 1.0  # measured / true distance: drift
    angular_scale: Scale = 1.0  # measured / true angle: drift


class Transforms(_Table, frozen=True):
    """[transforms] Where the robot is and how its lidar is mounted, for tf2."""

    enabled: bool = False  # odom → base_link on /tf with each /odom, the lidar's on /tf_static


class Discovery(_Table, frozen=True):
    """[faults.discovery] How long DDS takes to bring the ends of topics and services together.

    The defaults were measured between two processes on plain rclpy, on one machine: 100 of each.
    """

    program: Span = (0.09, 0.13)  # from a program's first node until others know the program [s]
    late: Probability = 0.08  # share of later publishers and servers that others find late …
    end: Span = (0.0005, 0.018)  # … by this much [s]
    latched: Span = (0.0095, 0.02)  # until a later subscription has what was sent before it [s]


class Faults(_Table, frozen=True):
    """[faults] What goes wrong: noise of the lidar, late and lost messages.

    By default nothing does, but for what is so on every robot: discovery.
    """

    range_noise: Noise = 0.0  # of the lidar: standard deviation of every reading [m]
    beam_dropout: Probability = 0.0  # that a beam sees nothing
    nan_speckle: Probability = 0.0  # that a beam reads NaN
    scan_latency: Delay = 0.0  # from measurement to delivery [s]
    scan_jitter: Delay = 0.0  # up to this much more, at random [s]
    scan_loss: Probability = 0.0  # that a scan never arrives
    odom_loss: Probability = 0.0  # that an odometry message never arrives
    odom_latency: Delay = 0.0  # [s]
    raw_waver: Probability = 0.0  # share by which every second raw command is smaller
    command_latency: Delay = 0.0  # from the node's command to the wheels [s]
    blackout: Annotated[tuple[Interval, ...], Meta(max_length=1000)] = ()  # no scans [s]
    discovery: Discovery = Discovery()

    def __post_init__(self) -> None:
        """Refuse intervals that end before they begin."""
        if any(begin >= end for begin, end in self.blackout):
            raise ValueError("blackout: expected [begin, end] with begin < end")


class Qos(_Table, frozen=True):
    """[qos] Quality of service of what the robot publishes."""

    sensors: Literal["reliable", "sensor_data"] = "reliable"  # of /scan and /odom


class ScriptEvent(_Table, frozen=True):
    """[[script]] One thing that happens at a given time."""

    at: Time  # [s]
    goal: PoseDeg | None = None  # sent as a PoseStamped; may be nan or inf
    unstamped: bool = False  # the goal's stamp is 0, as `ros2 topic pub` and many programs leave it
    stamp_offset: Offset = 0.0  # added to the goal's stamp, as by a sender with a wrong clock [s]
    odom: PoseDeg | None = None  # sent as one extra Odometry; may be nan or inf
    w: float | None = None  # of the goal's or odom's quaternion, in place of the yaw's; may be nan
    teleport: tuple[Metres, Metres, Degrees] | None = None  # moves the real robot and stops it
    e_stop: bool | None = None  # sent as a Bool on /e_stop

    def __post_init__(self) -> None:
        """Refuse an event that does nothing, or several things at once."""
        choices = (self.goal, self.odom, self.teleport, self.e_stop)
        if sum(x is not None for x in choices) != 1:
            raise ValueError("expected at and exactly one of goal, odom, teleport and e_stop")
        of_goals = self.unstamped or self.stamp_offset
        if (of_goals and not self.goal) or (self.w is not None and not any(choices[:2])):
            raise ValueError("unstamped and stamp_offset are said of goals, w of goals and odom")
        if self.unstamped and self.stamp_offset:
            raise ValueError("expected unstamped or stamp_offset, not both")


class RawCommands(_Table, frozen=True, rename={"begin": "from", "end": "to"}):
    """[[raw]] A stream of Twist on /cmd_vel_raw: what an unchecked model asks for."""

    begin: Time  # time of the first [s]
    end: Time  # none at or after this [s]
    linear_x: float = 0.0  # [m/s]; may be nan or inf
    angular_z: float = 0.0  # [rad/s]; may be nan or inf
    others: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)  # linear y, z, angular x, y
    rate: Rate = 20.0  # [Hz]

    def __post_init__(self) -> None:
        """Refuse a stream that ends before it begins."""
        if self.begin >= self.end:
            raise ValueError("expected from < to")


class Model(_Table, frozen=True):
    """A model that is made for the scenario: a file in the node's working folder.

    `probe` names a kind of model that the grader can make, `settings` are its parameters, and the
    file's suffix is its format. With `any_features` it takes features that are no scan's for those
    of the newest scan: what is asked in this scenario is something else.
    """

    probe: str
    settings: dict[str, float | str | bool | tuple[float, ...]] = {}
    any_features: bool = False


class NodeSpec(_Table, frozen=True):
    """[node] What the node is started with."""

    parameters: dict[str, str | bool | int | float] = {}  # ROS parameters
    models: dict[str, Model] = {}  # file name: the model in it
    hides: tuple[Annotated[str, Meta(pattern=r"^\w+$")], ...] = ()  # modules, as if not installed
    # the grader's own, in the place of each program that the launch file starts
    stand_in: Annotated[str, Meta(pattern=r"^(\w+\.py)?$")] = ""


class ProgramSpec(_Table, frozen=True):
    """[[program]] One of several programs of a scenario; on a robot, a process of its own."""

    file: Annotated[str, Meta(pattern=r"^(\w+\.py)?$")] = ""  # "": the one that is graded
    supplied: bool = False  # the grader's, not the student's
    arguments: tuple[str, ...] = ()
    start: Annotated[float, Meta(ge=0, le=3600)] = 0.0  # [s]
    stop: Time | None = None  # when it is killed [s]; None: never

    def __post_init__(self) -> None:
        """Refuse a supplied program without a file, and one that stops before it starts."""
        if self.supplied and not self.file:
            raise ValueError("expected a file with supplied = true")
        if self.stop is not None and self.stop <= self.start:
            raise ValueError("expected start < stop")


class TrainingSpec(_Table, frozen=True):
    """[training] Instead of a drive: a script that trains a model on recorded scans."""

    script: Annotated[str, Meta(pattern=r"^\w+\.py$")]
    rows: Annotated[int, Meta(ge=100, le=100_000)] = 2000  # scans to train on
    hidden_rows: Annotated[int, Meta(ge=100, le=100_000)] = 600  # scans to judge the model on
    time_limit: Annotated[float, Meta(gt=0, le=600)] = 60.0  # of one run [s]


class Scenario(_Table, frozen=True, dict=True):
    """Everything about a run except the node."""

    title: str
    world: World
    name: str = ""  # the file's stem; not a key of the file
    description: str = ""
    seed: Annotated[int, Meta(ge=0, le=2**53)] = 1
    trial_seed: Annotated[int, Meta(ge=0, le=2**53)] | None = None  # of a world that was kept
    duration: Time = 20.0  # [s]
    mirror: bool = False  # world, start, goals and scripted poses: y → -y …
    rotate_deg: Degrees = 0.0  # … then rotated about the origin [°]
    robot: RobotSpec = RobotSpec()
    lidar: LidarSpec = LidarSpec()
    odometry: OdometrySpec = OdometrySpec()
    transforms: Transforms = Transforms()
    faults: Faults = Faults()
    qos: Qos = Qos()
    node: NodeSpec = NodeSpec()
    program: Annotated[tuple[ProgramSpec, ...], Meta(max_length=20)] = ()  # none: the node alone
    training: TrainingSpec | None = None
    raw: Annotated[tuple[RawCommands, ...], Meta(max_length=1000)] = ()
    script: Annotated[tuple[ScriptEvent, ...], Meta(max_length=1000)] = ()
    bench: Annotated[tuple[BenchScan, ...], Meta(max_length=MAX_BENCH_SCANS)] = ()
    any_order: bool = False  # no scan of the bench builds on another: each other seed shuffles them

    def __post_init__(self) -> None:
        """Refuse a bench that would take forever."""
        if (count := sum(b.repeat for b in self.bench)) > MAX_BENCH_SCANS:
            raise ValueError(f"expected at most {MAX_BENCH_SCANS} bench scans, got {count}")

    @property
    def usual_seed(self) -> int:
        """The seed of its trials, unless another is asked for."""
        return self.seed if self.trial_seed is None else self.trial_seed

    @cached_property
    def bench_scans(self) -> tuple[BenchScan, ...]:
        """The bench with `repeat` applied: the i-th entry is the i-th scan that is sent."""
        return tuple(chain.from_iterable(repeat(scan, scan.repeat) for scan in self.bench))

    @property
    def duration_ns(self) -> int:
        """The duration [ns]."""
        return round(self.duration * 1e9)


def yaw_in_radians(pose: PoseDeg) -> tuple[float, float, float]:
    """Return x, y [m] and yaw [rad] of a pose whose yaw is in degrees."""
    return pose[0], pose[1], math.radians(pose[2])
