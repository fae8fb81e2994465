"""How fast the mock robot is: `python benchmarks/lidar.py`.

In one run, so that the ratio does not depend on the machine, and in CPU time of this process, so
that other programs count little: scans per second of our caster and of pymunk's own ray query (one
call a beam), and how many times faster than real time a whole simulation runs.
"""

import math
import time
from collections.abc import Callable
from itertools import cycle

import numpy as np
import pymunk

from sim.caster import Caster, static_faces
from sim.layout import Layout
from sim.lidar import PROFILES
from sim.placement import build_layout
from sim.scenario_files import load_scenario
from sim.simulation import Simulation
from sim.world import Clutter, Wall, World

ROOM = World(  # 4 walls and 24 boxes: 100 segments
    walls=(Wall(((-5, -5), (5, -5), (5, 5), (-5, 5)), closed=True),),
    clutter=(Clutter(((-4.5, -4.5), (4.5, 4.5)), 24, keep_clear=((0, 0, 1.5),)),),
)
PROFILE = PROFILES["default"]
SECONDS = 1.0  # for each measurement


def main() -> None:
    """Measure and print everything."""
    layout = build_layout(ROOM, rng=np.random.default_rng(7))
    angles = np.linspace(0, math.tau, 500, endpoint=False)
    poses = np.column_stack((1.2 * np.cos(angles), 1.2 * np.sin(angles), 5 * angles)).tolist()
    caster = Caster(
        static_faces(layout),
        beams=PROFILE.beams,
        per_turn=PROFILE.per_turn,
        angle_min=PROFILE.angle_min,
        range_max=PROFILE.range_max,
    )
    ours = per_second(caster.cast, poses)
    theirs = per_second(ray_queries(layout), poses)
    print(f"lidar, {PROFILE.beams} beams, {len(layout.segments())} segments")
    print(f"  angular sweep       {ours:10,.0f} scans/s")
    print(f"  pymunk, ray by ray  {theirs:10,.0f} scans/s")
    print(f"  ratio               {ours / theirs:10.1f}")
    print(f"simulation, demo_wall {real_time_factor('demo_wall'):,.0f} x real time")


def per_second(scan: Callable[[float, float, float], object], poses: list[list[float]]) -> float:
    """Return how many scans a second it makes, going round the poses [m, m, rad]."""
    for x, y, yaw in poses:  # the first round fills caches
        scan(x, y, yaw)
    count, begin = 0, time.process_time()
    for x, y, yaw in cycle(poses):
        scan(x, y, yaw)
        count += 1
        if count % 10 == 0 and time.process_time() - begin > SECONDS:
            break
    return count / (time.process_time() - begin)


def ray_queries(layout: Layout) -> Callable[[float, float, float], list[float]]:
    """Return a scan of pymunk's: `segment_query_first` for every beam."""
    space = pymunk.Space()
    for a, b in layout.segments().tolist():
        space.add(pymunk.Segment(space.static_body, tuple(a), tuple(b), 0.0))
    space.step(0.01)
    everything = pymunk.ShapeFilter()
    reach = PROFILE.range_max
    beams = PROFILE.angles.tolist()

    def scan(x: float, y: float, yaw: float) -> list[float]:
        ranges = []
        for beam in beams:
            end = x + reach * math.cos(beam + yaw), y + reach * math.sin(beam + yaw)
            hit = space.segment_query_first((x, y), end, 0.0, everything)
            ranges.append(hit.alpha * reach if hit else math.inf)
        return ranges

    return scan


def real_time_factor(name: str) -> float:
    """Return simulated over real time for a robot that drives in circles through a scenario."""
    scenario = load_scenario(name)
    best = math.inf
    for _ in range(5):
        simulation = Simulation(scenario)
        begin = time.process_time()
        while (event := simulation.next_event()) is not None:
            simulation.advance(event, [(simulation.now, 0.3, 0.5)])
        simulation.truth()
        best = min(best, time.process_time() - begin)
    return scenario.duration / best


if __name__ == "__main__":
    main()
