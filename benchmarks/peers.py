"""What this project costs beside others that do a part of it, all in one run: `make bench`.

Each figure is a median of five and stands beside a peer's, because absolute times differ from
machine to machine. pymunk and plain rclpy are the ones in this environment; ir-sim, nbgrader and
otter-grader get one each in build/peers, which pip fills when it is not there.
"""

import contextlib
import math
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
import venv
from collections.abc import Callable, Sequence
from itertools import cycle
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pymunk

from grader.classroom.queue.work import Unit, grade_unit
from grader.course.exercises import find_exercise
from grader.course.submission import Submission
from grader.launchers import fork_server
from grader.trial.virtual_time import run_trial
from rclpy_virtual_time import ForkServer
from sim.caster import Caster, static_faces
from sim.layout import Layout
from sim.lidar import PROFILES
from sim.placement import build_layout
from sim.scenario import Scenario
from sim.scenario_files import load_scenario
from sim.world import Clutter, Wall, World

ROOT = Path(__file__).resolve().parent.parent
SOLUTION = ROOT / "solutions/obstacle_avoidance/obstacle_avoidance_agent.py"
PEERS = ROOT / "build" / "peers"
RUNS = 5
SECONDS = 60.0  # simulated
BOXES = 20
FIELD = Wall(((-5, -5), (5, -5), (5, 5), (-5, 5)), closed=True)
LIDAR = PROFILES["default"]

ECHO = """
import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan

class Echo(Node):
    def __init__(self):
        super().__init__('echo')
        self.publisher = self.create_publisher(Twist, '/cmd_vel', 10)
        self.create_subscription(LaserScan, '/scan', self.on_scan, 10)
    def on_scan(self, scan):
        self.publisher.publish(Twist())
"""
SPIN = "rclpy.init(); rclpy.spin(Echo())"
CIRCLE = """
from nav_msgs.msg import Odometry
class Controller(Echo):
    def __init__(self):
        super().__init__()
        self.create_subscription(Odometry, '/odom', lambda _: None, 10)
        self.create_timer(0.1, self.control)
    def control(self):
        command = Twist()
        command.linear.x, command.angular.z = 0.2, 0.3
        self.publisher.publish(command)
    def on_scan(self, scan):
        pass
rclpy.init(); rclpy.spin(Controller())
"""
PLAIN = """
import time
from rclpy.serialization import serialize_message
rclpy.init()
node, robot = Echo(), Node('robot')
speaker = robot.create_publisher(LaserScan, '/scan', 10)
listener = robot.create_subscription(Twist, '/cmd_vel', print, 10, raw=True)
scan = serialize_message(LaserScan(ranges=[1.0] * 360))
def step():
    speaker.publish(scan)
    while (message := listener.handle.take_message(Twist, True)) is None:
        rclpy.spin_once(node, timeout_sec=0)
for _ in range(200): step()
start = time.perf_counter()
for _ in range(2000): step()
print((time.perf_counter() - start) / 2000)
"""
IR_SIM = """
import sys, time, irsim, numpy as np
world = irsim.make(sys.argv[1], display=False, log_level='ERROR')
def drive(steps):
    for _ in range(steps):
        world.step(np.array([[0.2], [0.3]]))
        world.get_lidar_scan()
drive(20)
start = time.perf_counter()
drive(300)
print(30 / (time.perf_counter() - start))
"""
IR_WORLD = f"""
world: {{height: 10, width: 10, step_time: 0.1, sample_time: 0.1, collision_mode: unobstructed}}
robot:
  - kinematics: {{name: diff}}
    shape: {{name: circle, radius: 0.17}}
    state: [5, 5, 0]
    sensors: [{{name: lidar2d, range_min: 0.15, range_max: 12, angle_range: 6.2832, number: 360}}]
obstacle:
  - number: {BOXES}
    distribution: {{name: random, range_low: [0.5, 0.5, -3.1], range_high: [9.5, 9.5, 3.1]}}
    shape: {{name: rectangle, length: 0.4, width: 0.4}}
"""
NBGRADER = "c = get_config()\nc.CourseDirectory.course_id = 'bench'\n"
OTTER = """
OK_FORMAT = True
case = {"code": ">>> 1 + 1\\n2", "hidden": False, "locked": False}
suite = {"cases": [case], "scored": True, "setup": "", "teardown": "", "type": "doctest"}
test = {"name": "q1", "points": 1, "suites": [suite]}
"""


def main() -> None:
    """Print the table."""
    print(f"{'':58}{'ours':>10}{'peer':>10}{'ratio':>8}")
    row("lidar, 100 segments [scans/s] / pymunk, a query a beam", *_lidar())
    with tempfile.TemporaryDirectory() as name, fork_server() as forkserver:
        folder = Path(name)
        row("scan to cmd_vel [ms] / plain rclpy in one process", *_step(folder, forkserver))
        row("trial [x real time] / ir-sim, without ROS", *_pace(folder, forkserver))
    row("cold `course grade` of exercise 1 [s] / its imports", *_cold())
    ours = _submission()
    row("CPU of its submission [s] / nbgrader, a trivial cell", ours, _nbgrader())
    row("CPU of its submission [s] / otter-grader, a trivial cell", ours, _otter())


def row(name: str, ours: float, peer: float) -> None:
    """Print a figure, its peer's, and the ratio."""
    print(f"{name:58}{ours:10,.3g}{peer:10,.3g}{ours / peer:8.2f}", flush=True)


def median(measure: Callable[[], float]) -> float:
    """Return the median of some runs."""
    return statistics.median(measure() for _ in range(RUNS))


# --- the robot and its middleware ----------------------------------------------------------------


def _lidar() -> tuple[float, float]:
    """Count scans in a second of CPU time, ours and pymunk's."""
    world = World(walls=(FIELD,), clutter=_boxes(24))
    layout = build_layout(world, rng=np.random.default_rng(7))
    angles = np.linspace(0, math.tau, 500, endpoint=False)
    poses = np.column_stack((1.2 * np.cos(angles), 1.2 * np.sin(angles), 5 * angles)).tolist()
    ours = Caster(
        static_faces(layout), beams=LIDAR.beams, per_turn=LIDAR.per_turn,
        angle_min=LIDAR.angle_min, range_max=LIDAR.range_max,
    )  # fmt: skip
    return _scans_per_second(ours.cast, poses), _scans_per_second(_queries(layout), poses)


def _boxes(count: int) -> tuple[Clutter, ...]:
    return (Clutter(((-4.5, -4.5), (4.5, 4.5)), count, keep_clear=((0, 0, 1.5),)),)


def _scans_per_second(
    scan: Callable[[float, float, float], object], poses: Sequence[list[float]]
) -> float:
    for x, y, yaw in poses:  # the first round fills caches
        scan(x, y, yaw)
    count, begin = 0, time.process_time()
    for x, y, yaw in cycle(poses):
        scan(x, y, yaw)
        count += 1
        if count % 10 == 0 and time.process_time() - begin > 1.0:
            break
    return count / (time.process_time() - begin)


def _queries(layout: Layout) -> Callable[[float, float, float], object]:
    """Return a scan of pymunk's: `segment_query_first` for every beam."""
    space = pymunk.Space()
    for a, b in layout.segments().tolist():
        space.add(pymunk.Segment(space.static_body, tuple(a), tuple(b), 0.0))
    space.step(0.01)
    everything = pymunk.ShapeFilter()
    beams = LIDAR.angles.tolist()

    def scan(x: float, y: float, yaw: float) -> None:
        for beam in beams:
            end = (
                x + LIDAR.range_max * math.cos(beam + yaw),
                y + LIDAR.range_max * math.sin(beam + yaw),
            )
            space.segment_query_first((x, y), end, 0.0, everything)

    return scan


def _scenario(**changes: object) -> Scenario:
    return msgspec.structs.replace(load_scenario("demo_wall"), duration=SECONDS, **changes)


def _node(folder: Path, source: str) -> Submission:
    file = folder / "node.py"
    file.write_text(source)
    return Submission(file)


def _step(folder: Path, forkserver: ForkServer) -> tuple[float, float]:
    """Measure from a scan to its command [ms], across the wall and in one process without it."""
    silent = msgspec.structs.replace(_scenario().odometry, enabled=False)
    node = _node(folder, ECHO + SPIN)

    def ours() -> float:
        recording = run_trial(node, _scenario(odometry=silent), forkserver)
        assert len(recording.published) == len(recording.delivered) > 500
        return float(np.median(recording.compute.wall[2:])) * 1e3

    file = folder / "plain.py"
    file.write_text(ECHO + PLAIN)
    environment = {
        **forkserver.ros.variables(),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF",
        "ROS_LOG_DIR": str(folder),
    }
    return median(ours), median(lambda: float(said(sys.executable, file, env=environment)) * 1e3)


def _pace(folder: Path, forkserver: ForkServer) -> tuple[float, float]:
    """Simulate a circle among boxes: 360 beams at 10 Hz; ours has odometry and a node, too."""
    node = _node(folder, ECHO + CIRCLE)
    scenario = _scenario(world=World(walls=(FIELD,), clutter=_boxes(BOXES)))

    def ours() -> float:
        start = time.perf_counter()
        recording = run_trial(node, scenario, forkserver)
        elapsed = time.perf_counter() - start - recording.compute.wall[0]
        assert recording.outcome.completed
        return SECONDS / float(elapsed)

    world, program = folder / "world.yaml", folder / "drive.py"
    world.write_text(IR_WORLD)
    program.write_text(IR_SIM)
    python = peer("ir-sim", "ir-sim==2.12.0")
    return median(ours), median(lambda: float(said(python, program, world).split()[-1]))


# --- grading --------------------------------------------------------------------------------------


def _cold() -> tuple[float, float]:
    """Time a whole command, and a Python that imports what it needs [s]."""
    grade = (sys.executable, "-m", "grader.cli", "grade", "obstacle_avoidance", SOLUTION)
    imports = (sys.executable, "-c", "import numpy, pymunk, pytest, rich, rosbags.typesys")
    return median(lambda: _wall(*grade)), median(lambda: _wall(*imports))


def _submission() -> float:
    """Return what a worker of a class uses for the reference of exercise 1, warm [s of CPU]."""
    unit = _reference_unit("obstacle_avoidance")
    grade_unit(unit)

    def once() -> float:
        before = _cpu_seconds()
        grade_unit(unit)
        return _cpu_seconds() - before

    return median(once)


def _nbgrader() -> float:
    python = peer("nbgrader", "nbgrader==0.9.6", "ipykernel")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "nbgrader_config.py").write_text(NBGRADER)
        metadata = {"grade": True, "grade_id": "one", "locked": True, "points": 1,
                    "schema_version": 3, "solution": False, "task": False}  # fmt: skip
        for part in ("source/one", "submitted/ann/one"):
            (folder / part).mkdir(parents=True)
            notebook(folder / part / "one.ipynb", {"nbgrader": metadata})
        said(python, "-m", "nbgrader", "generate_assignment", "one", cwd=folder)
        autograde = (python, "-m", "nbgrader", "autograde", "one", "--force")
        return median(lambda: _cpu(*autograde, cwd=folder))


def _otter() -> float:
    python = peer("otter-grader", "otter-grader==7.0.0", "ipykernel")
    otter = python.parent / "otter"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "tests").mkdir()
        (folder / "tests" / "q1.py").write_text(OTTER)
        notebook(folder / "one.ipynb", {})
        without = ("--no-requirements", "--no-environment")
        said(otter, "generate", "-t", "tests", "-o", "grader.zip", *without, cwd=folder)
        run = (otter, "run", "-a", "grader.zip", "--no-logo", "one.ipynb")
        return median(lambda: _cpu(*run, cwd=folder))


def notebook(file: Path, metadata: dict[str, object]) -> None:
    """Write a notebook with one trivial cell."""
    cell: dict[str, object] = {"cell_type": "code", "id": "one", "source": "assert 1 + 1 == 2"}
    cell |= {"outputs": [], "execution_count": None, "metadata": metadata}
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    content = {"cells": [cell], "metadata": {"kernelspec": kernel}, "nbformat": 4}
    file.write_bytes(msgspec.json.encode({**content, "nbformat_minor": 5}))


# --- processes ------------------------------------------------------------------------------------


def peer(name: str, *requirements: str) -> Path:
    """Return the Python of a peer's own environment; make it if it is not there."""
    folder = PEERS / name
    python = folder / "bin" / "python"
    if not (folder / "made").exists():
        venv.create(folder, with_pip=True, clear=True)
        said(
            python, "-m", "pip", "--quiet", "--disable-pip-version-check", "install", *requirements
        )
        (folder / "made").touch()
    return python


def said(program: object, *arguments: object, **how: Any) -> str:
    """Run a program of a peer's environment; return what it printed.

    Its folder is the first of those that are searched: nbgrader starts `alembic` by name.
    """
    where = os.pathsep.join([str(Path(str(program)).parent), os.environ["PATH"]])
    how = {"env": {**os.environ, "PATH": where}, **how}
    command = [str(part) for part in (program, *arguments)]
    done = subprocess.run(
        command, check=True, text=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, **how
    )
    return str(done.stdout)


def _wall(*command: object) -> float:
    start = time.perf_counter()
    said(*command, cwd=ROOT)
    return time.perf_counter() - start


def _cpu(*command: object, cwd: Path) -> float:
    before = _children()
    said(*command, cwd=cwd)
    return _children() - before


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _reference_unit(name: str) -> Unit:
    """Return an exercise's reference, as a student's submission."""
    exercise = find_exercise(name)
    texts = {file: (exercise.solutions / file).read_bytes() for file in exercise.files}
    return Unit("warm", exercise.slug, texts, bags=False)


def _cpu_seconds() -> float:
    """Return the CPU time of this process and its descendants, dead ones included [s].

    The host's fork server lives on from unit to unit, so `os.times` does not have the nodes.
    """
    return sum(_ticks(pid) for pid in _family(os.getpid())) / os.sysconf("SC_CLK_TCK")


def _family(pid: int) -> list[int]:
    """Return a process and its living descendants."""
    found = [pid]
    with contextlib.suppress(OSError):
        for task in Path(f"/proc/{pid}/task").iterdir():
            for child in (task / "children").read_text().split():
                found += _family(int(child))
    return found


def _ticks(pid: int) -> int:
    """Return the CPU time of a process and of the children it has waited for [ticks]."""
    try:
        after_name = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0
    return sum(map(int, after_name[11:15]))


if __name__ == "__main__":
    main()
