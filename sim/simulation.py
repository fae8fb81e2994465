"""The mock robot: one scenario, advanced from event to event.

Observations (messages that `advance` returns)

| message       | topic      | content                        | unit       | range              |
|---------------|------------|--------------------------------|------------|--------------------|
| LaserScan     | /scan      | ranges, 360 beams from -π up   | m          | 0.15 … 12, ±inf    |
| Odometry      | /odom      | pose x, y                      | m          | any                |
|               |            | pose yaw, as a quaternion      | rad        | -π … π             |
|               |            | twist linear.x, angular.z      | m/s, rad/s | ±0.5, ±1.9         |
| PoseStamped   | /goal_pose | a goal of the script           | m, rad     | any, also nan, inf |
| TFMessage     | /tf        | base_link in odom, as /odom    | m, rad     | any                |
| TFMessage     | /tf_static | the lidar in base_link, once   | m, rad     | ±0.5, -π … π       |

Actions (`commands` of `advance`)

| field         | meaning                        | unit       | limited to         |
|---------------|--------------------------------|------------|--------------------|
| linear.x      | forward speed                  | m/s        | ±0.5               |
| angular.z     | turning speed, left positive   | rad/s      | ±1.9               |

Ranges and limits are the defaults; `[lidar]` and `[robot]` of the scenario change them.

Dynamics
    A differential drive in steps of 10 ms. A command takes effect in the first step that begins at
    or after its time (plus `[faults] command_latency`); the wheels ramp toward it by at most
    0.9 m/s² and 7 rad/s². They ramp to zero 0.5 s after the last command has arrived. A command
    that is not finite counts as zero. Contacts are inelastic: the robot stops at what it hits.
    Sensors measure between steps by linear interpolation.

Start
    `[robot] start`, plus a uniform jitter that the seed draws. The robot is at rest.

End
    `next_event` is None once everything that arrives within `duration` has arrived. Nothing that
    the robot does ends a run early.

Determinism
    Scenario and seed fix every byte; how `advance` is cut into pieces does not matter.

Units and frames follow REP-103 and REP-105, readings REP-117.
"""

import itertools
import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from sim.bench import varied
from sim.clearance import clearance
from sim.events import Event, Kind
from sim.faults import sensor_rng
from sim.layout import Floats, Layout, Pose
from sim.messages import (
    CMD_VEL_RAW_TOPIC,
    E_STOP_TOPIC,
    EPOCH_NS,
    Message,
    bool_,
    odometry,
    pose_stamped,
    twist,
)
from sim.odometry import Odometry
from sim.placement import place, scenario_layout
from sim.robot import STEP_NS, Robot
from sim.scanner import Scanner
from sim.scenario import Scenario, ScriptEvent, yaw_in_radians
from sim.schedule import RAW_STREAM, schedule
from sim.sensors import SENSORS, TOPIC_OF

TRUTH_NS = 20_000_000  # between two samples of the truth [ns]


@dataclass(frozen=True, eq=False)
class Truth:
    """The ground truth: (n,) samples, one every 20 ms from time 0."""

    t: NDArray[np.int64]  # since the scenario's start [ns]
    x: Floats  # [m]
    y: Floats  # [m]
    yaw: Floats  # -π … π [rad]
    v: Floats  # forward speed [m/s]
    w: Floats  # turning speed [rad/s]
    clearance: Floats  # from the robot's edge to the nearest obstacle, 0 in contact, at most 10 [m]
    contact: NDArray[np.bool_]  # touched anything since the previous sample


class Simulation:
    """One run of a scenario.

    Raises InputError: the robot's start is not free, or the clutter does not fit.

    Parameters
    ----------
    scenario
        What happens.
    seed
        Takes the place of the scenario's own: the only door for randomness.
    """

    scenario: Scenario  # with the bench as this seed has it
    layout: Layout
    seed: int
    now: int  # since the scenario's start [ns]

    def __init__(self, scenario: Scenario, seed: int | None = None) -> None:
        self.seed = scenario.usual_seed if seed is None else seed
        self.scenario = scenario = _of_seed(scenario, self.seed)
        self.now = 0
        self.layout = scenario_layout(scenario, self.seed)
        self._robot = Robot(scenario.robot, self.layout)
        self._sensors = [sensor(scenario, self.layout, self.seed) for sensor in SENSORS]
        [self._odometry] = [each for each in self._sensors if isinstance(each, Odometry)]
        [self._scanner] = [each for each in self._sensors if isinstance(each, Scanner)]
        self._plan(schedule(scenario, self.seed))
        self._stepped = 0  # time that the physics has reached [ns]
        self._late = round(scenario.faults.command_latency * 1e9)  # [ns]
        self._commands: list[tuple[int, float, float]] = []  # not yet in effect, by time
        self._command = (-(10**18), 0.0, 0.0)
        self._samples = [self._sample(contact=False)]
        self._touched = False

    @property
    def pose(self) -> Pose:
        """The true pose after the last step [m, m, rad]; its yaw is not wrapped."""
        return self._robot.pose

    @property
    def end(self) -> int:
        """When the scenario ends, since its start [ns]."""
        return self.scenario.duration_ns

    def next_event(self, topics: Collection[str] | None = None) -> int | None:
        """Return when the next message or scripted event comes after `now` [ns], if any.

        `topics` are those whose messages alone count, and nothing that the script does.
        """
        coming = itertools.islice(self._arrivals, self._arrived, None)
        wanted = (each for each in coming if topics is None or TOPIC_OF.get(each.kind) in topics)
        return next((event.delivery for event in wanted), None)

    def advance(
        self, until: int, commands: Sequence[tuple[int, float, float]] = ()
    ) -> list[Message]:
        """Advance to `until` [ns] and return the messages that arrive after `now` and by then.

        Raises ValueError: `until` is before `now`.

        Parameters
        ----------
        until
            Since the scenario's start [ns], not before `now`.
        commands
            Time [ns], linear.x [m/s] and angular.z [rad/s] of each, as sent; one that arrives
            before `now` takes effect in the next step, one after `until` when its time has come.
        """
        if until < self.now:
            raise ValueError(f"cannot advance to {until} ns: it is already {self.now} ns")
        if commands:
            arriving = ((time + self._late, v, w) for time, v, w in commands)
            self._commands = sorted([*self._commands, *arriving], key=lambda command: command[0])
        while self._stepped < until:
            self._step()
        self.now = until
        return self._arrive()

    def truth(self) -> Truth:
        """Return the ground truth up to `now`."""
        rows = np.array(self._samples[: self.now // TRUTH_NS + 1], float)
        x, y, yaw, v, w, contact = rows.T
        t = np.arange(len(rows), dtype=np.int64) * TRUTH_NS
        touched = contact > 0
        free = clearance(self.layout, t / 1e9, rows[:, :2], self.scenario.robot.radius)
        free[touched] = 0.0
        yaw = (yaw + math.pi) % math.tau - math.pi
        return Truth(t, x.copy(), y.copy(), yaw, v.copy(), w.copy(), free, touched)

    def _plan(self, events: list[Event]) -> None:
        teleports = [event for event in events if event.kind == Kind.TELEPORT]
        measurements = [event for event in events if event.kind != Kind.TELEPORT]
        self._teleports = teleports[::-1]  # the next one last
        self._measurements = measurements[::-1]
        self._arrivals = sorted(events, key=lambda e: (e.delivery, e.kind, e.index))
        self._arrived = 0  # number of arrivals that are over
        self._messages: dict[tuple[int, int], Message] = {}  # measured, not yet delivered

    def _step(self) -> None:
        """Do one step of physics, and make the measurements that fall into it."""
        start = self._stepped
        while self._teleports and self._teleports[-1].time <= start:
            self._teleport(self._script(self._teleports.pop()))
        robot = self._robot
        before, v, w = robot.pose, robot.v, robot.w
        robot.step(start / 1e9, *self._wheel_speeds(start))
        self._stepped = end = start + STEP_NS
        self._touched |= robot.touched
        if end % TRUTH_NS == 0:
            self._samples.append(self._sample(contact=self._touched))
            self._touched = False
        while self._measurements and self._measurements[-1].time <= end:
            event = self._measurements.pop()
            part = (event.time - start) / STEP_NS
            pose = _between(before, robot.pose, part)
            speeds = v + part * (robot.v - v), w + part * (robot.w - w)
            self._messages[event.kind, event.index] = self._measure(event, pose, speeds)

    def _wheel_speeds(self, start: int) -> tuple[float, float]:
        """Return the command in effect at this time [ns], zero once it is too old."""
        while self._commands and self._commands[0][0] <= start:
            self._command = self._commands.pop(0)
        time, linear, angular = self._command
        if start - time > self.scenario.robot.command_timeout * 1e9:
            return 0.0, 0.0
        if not (math.isfinite(linear) and math.isfinite(angular)):
            return 0.0, 0.0
        return linear, angular

    def _sample(self, *, contact: bool) -> tuple[float, ...]:
        robot = self._robot
        return (*robot.pose, robot.v, robot.w, contact)

    def _measure(self, event: Event, pose: Pose, speeds: tuple[float, float]) -> Message:
        match event.kind:
            case Kind.TRANSFORM:
                return self._odometry.transform(event)
            case Kind.STATIC_TRANSFORM:
                return self._scanner.transform(event)
            case Kind.RAW:
                return self._raw(event)
            case Kind.GOAL | Kind.E_STOP | Kind.SCRIPTED_ODOM:
                return self._scripted(event)
        return self._sensors[Kind.SENSOR - event.kind].message(event, pose, speeds)

    def _raw(self, event: Event) -> Message:
        """Return a command of a stream on /cmd_vel_raw."""
        index, i = divmod(event.index, RAW_STREAM)
        stream = self.scenario.raw[index]
        share = 1.0 - self.scenario.faults.raw_waver * (i % 2)
        return twist(
            time=event.time,
            linear_x=stream.linear_x * share,
            others=stream.others,
            angular_z=stream.angular_z * share,
            topic=CMD_VEL_RAW_TOPIC,
        )

    def _scripted(self, event: Event) -> Message:
        """Return what the script sends: an e-stop, a goal or an extra pose."""
        time, entry = event.time, self._script(event)
        if event.kind == Kind.E_STOP:
            return bool_(E_STOP_TOPIC, time, bool(entry.e_stop))
        x, y, yaw = self._scripted_pose(entry)
        if event.kind == Kind.SCRIPTED_ODOM:
            return odometry(time=time, x=x, y=y, yaw=yaw, qw=entry.w)
        stamp = -EPOCH_NS if entry.unstamped else time + round(entry.stamp_offset * 1e9)
        return pose_stamped(time=time, x=x, y=y, yaw=yaw, w=entry.w, stamp=stamp)

    def _script(self, event: Event) -> ScriptEvent:
        return self.scenario.script[event.index]

    def _scripted_pose(self, entry: ScriptEvent) -> Pose:
        pose = entry.goal or entry.odom or entry.teleport
        assert pose is not None  # ScriptEvent has exactly one of them
        scenario = self.scenario
        return place(yaw_in_radians(pose), mirror=scenario.mirror, rotate_deg=scenario.rotate_deg)

    def _teleport(self, entry: ScriptEvent) -> None:
        pose = self._scripted_pose(entry)
        self._robot.teleport(pose)
        self._odometry.jump(pose)

    def _arrive(self) -> list[Message]:
        """Return the messages that have arrived by `now`, in order."""
        messages = []
        while self._arrived < len(self._arrivals):
            event = self._arrivals[self._arrived]
            if event.delivery > self.now:
                break
            self._arrived += 1
            if event.kind != Kind.TELEPORT:
                messages.append(self._messages.pop((event.kind, event.index)))
        return messages


def _between(before: Pose, after: Pose, part: float) -> Pose:
    (x0, y0, yaw0), (x1, y1, yaw1) = before, after
    return x0 + part * (x1 - x0), y0 + part * (y1 - y0), yaw0 + part * (yaw1 - yaw0)


def _of_seed(scenario: Scenario, seed: int) -> Scenario:
    """Return the scenario with its bench as the seed has it; its own seed has it as written."""
    if not scenario.bench or seed == scenario.seed:
        return scenario
    bench = varied(scenario.bench, scenario.any_order, sensor_rng(seed, "bench"))
    return msgspec.structs.replace(scenario, bench=bench)
