"""The lidar on the robot: casts a scan from a pose, adds the faults, packs the message."""

import math

import numpy as np
from numpy.typing import NDArray

from sim.bench import bench_ranges
from sim.caster import Caster, faces, static_faces
from sim.events import Event, periodic
from sim.faults import Times, deliveries, measured, sensor_rng, speckle, survivors
from sim.layout import Floats, Layout, Pose, in_frame
from sim.lidar import PROFILES, bench_readings, readings
from sim.messages import (
    BASE_FRAME,
    LASER_SCAN,
    SCAN_TOPIC,
    TF_STATIC_TOPIC,
    Message,
    laser_scan,
    transform,
)
from sim.scenario import Scenario


class Scanner:
    """Makes the scans of one run, one after another.

    Parameters
    ----------
    scenario, layout
        Profile, faults and bench; what can be seen.
    seed
        With one that is not the scenario's own, the bench is jittered.
    """

    topic, type, table = SCAN_TOPIC, LASER_SCAN, "lidar"

    def __init__(self, scenario: Scenario, layout: Layout, seed: int) -> None:
        self._scenario, self._seed = scenario, seed
        self._carts = [(cart, faces(cart.polygon)) for cart in layout.carts]
        self._held = -1, np.empty(0, np.float32)  # the bench's latest entry, and its readings
        self._rng = sensor_rng(seed, "lidar")
        repeats = [scan.repeat for scan in scenario.bench]
        self._entries = np.repeat(np.arange(len(repeats)), repeats)  # of the bench, by scan
        self._profile = profile = scenario.lidar.measures
        self._scan_time = 1.0 / self.rate(scenario)
        self._mount = scenario.lidar.pose
        self._caster = Caster(
            static_faces(layout),
            beams=profile.beams,
            per_turn=profile.per_turn,
            angle_min=profile.angle_min,
            range_max=profile.range_max,
        )

    @staticmethod
    def rate(scenario: Scenario) -> float:
        """Return its scans per second [Hz]."""
        return scenario.lidar.rate or PROFILES[scenario.lidar.profile].rate

    @staticmethod
    def arrivals(scenario: Scenario, seed: int) -> tuple[Times, Times]:
        """Return when the scans that arrive are measured, and when they arrive [ns]."""
        faults = scenario.faults
        rng = sensor_rng(seed, "lidar link")
        times = periodic(scenario.lidar.phase, Scanner.rate(scenario), scenario.duration)
        times = times[survivors(times, faults.scan_loss, rng, faults.blackout)]
        if scenario.bench:
            times = times[: len(scenario.bench_scans)]
        return times, deliveries(times, faults.scan_latency, faults.scan_jitter, rng)

    def message(self, event: Event, pose: Pose, speeds: tuple[float, float]) -> Message:
        """Return the scan of this event, measured with the robot at the pose [m, m, rad]."""
        profile = self._profile
        return laser_scan(
            time=event.delivery,
            stamp=event.time + self._stamp_offset(event),
            ranges=self._readings(event, pose),
            angle_min=profile.angle_min,
            angle_increment=profile.angle_increment,
            range_min=profile.range_min,
            range_max=profile.range_max,
            scan_time=self._scan_time,
            frame_id=self._scenario.lidar.frame,
        )

    def transform(self, event: Event) -> Message:
        """Return where the lidar is on the robot, for tf2."""
        x, y, yaw = self._mount
        return transform(
            time=event.time, parent=BASE_FRAME, child=self._scenario.lidar.frame,
            x=x, y=y, yaw=yaw, topic=TF_STATIC_TOPIC,
        )  # fmt: skip

    def _stamp_offset(self, event: Event) -> int:
        """Return what a bench scan adds to its stamp [ns]."""
        if not self._scenario.bench:
            return 0
        return round(self._scenario.bench_scans[event.index].stamp_offset * 1e9)

    def _readings(self, event: Event, pose: Pose) -> NDArray[np.float32]:
        if self._scenario.bench:
            return self._bench_readings(int(self._entries[event.index]))
        faults = self._scenario.faults
        mounted = in_frame(pose, self._mount)
        ranges = self._caster.cast(*mounted, moving=self._moving(event.time))
        ranges = measured(ranges, faults, self._rng)
        return speckle(readings(ranges, self._profile), faults, self._rng)

    def _bench_readings(self, entry: int) -> NDArray[np.float32]:
        """Return the (n,) readings [m] of an entry of the bench, however often it is repeated."""
        if self._held[0] != entry:
            jitter = None
            if self._seed != self._scenario.seed:
                jitter = sensor_rng(self._seed, f"bench {entry}")
            turned = self._mount[2]  # a bench counts from the robot's front
            ranges = bench_ranges(self._scenario.bench[entry], self._profile, jitter, turned)
            self._held = entry, bench_readings(ranges, self._profile)
        return self._held[1]

    def _moving(self, time: int) -> Floats | None:
        """Return the (n, 2, 2) faces of all carts [m] at a time [ns]."""
        parts = []
        for cart, outline in self._carts:
            x, y, yaw = cart.pose(time / 1e9)
            c, s = math.cos(yaw), math.sin(yaw)
            parts.append(outline @ np.array(((c, s), (-s, c))) + (x, y))
        return np.concatenate(parts) if parts else None
