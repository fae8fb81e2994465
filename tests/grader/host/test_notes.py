"""What a host notes for a person: each node here does the same on plain rclpy."""

import re
from pathlib import Path

import msgspec
import pytest
from node_runs import PREAMBLE, short

from grader.course.exercises import find_exercise
from grader.course.submission import Submission, find_submission
from grader.recording import Outcome, growth_of
from grader.trial.recorder import Recorder
from grader.trial.virtual_time import run_trial
from rclpy_virtual_time.host.frames import Note
from rclpy_virtual_time.link.hosts import ForkServer
from sim.scenario import Discovery, Faults
from sim.scenario_files import load_scenario
from sim.simulation import Simulation

HEAD = f"""{PREAMBLE}
from rclpy.lifecycle import LifecycleNode
from std_srvs.srv import Trigger
rclpy.init()
node = Node('own')
def yes(request, response):
    return response
def spin(*nodes, threads=1):
    executor = SingleThreadedExecutor() if threads == 1 else MultiThreadedExecutor(threads)
    for each in nodes:
        executor.add_node(each)
    executor.spin()
"""
ALONE = "MutuallyExclusiveCallbackGroup()"
LATE = """
def say():
    timer.cancel()
    publisher = node.create_publisher(Twist, '/cmd_vel', 10)
    for _ in range(3):
        publisher.publish(Twist())
"""
SPINS = """
other = Node('other')
def tick():
    timer.cancel()
    for _ in range(12):
        rclpy.spin_once(other, timeout_sec=0.1)
timer = node.create_timer(0.5, tick)
node.create_subscription(LaserScan, '/scan', print, 10)
spin(node)
"""
ASKS = """
node.create_service(Trigger, '/detect', yes)
client = node.create_client(Trigger, '/detect'{client})
async def ask():
    await client.call_async(Trigger.Request())
node.create_timer(0.3, ask{timer})
spin(node)
"""
SLEEPS = """
def tick(): time.sleep(1.2)
node.create_timer(0.5, tick, callback_group={group})
node.create_subscription(LaserScan, '/scan', print, 10)
spin(node, threads={threads})
"""
THREADS = """
def work(): pass
def tick():
    {start}
node.create_timer(0.1, tick)
threads = [threading.Thread(target=work) for _ in range(20)]
for thread in threads: thread.start()
spin(node)
"""
FOR_LONG = "def tick(): {}\nnode.create_timer(0.1, tick)\nspin(node)"
SAID = [
    ("node.create_publisher(Twist, '/cmd_vel', 1).publish(Twist())\nspin(node)", "1 message on"),
    ("publisher = node.create_publisher(Twist, '/cmd_vel', 1)\n"
     "node.create_timer(0.1, lambda: publisher.publish(Twist()))\nspin(node)", ""),
    (f"{LATE}timer = node.create_timer(0.5, say)\nspin(node)", "3 messages on /cmd_vel"),
    ("managed = LifecycleNode('managed')\nspin(managed)",
     "/managed waits in the state unconfigured: .* `ros2 lifecycle set /managed configure`"),
    ("managed = LifecycleNode('managed')\nmanaged.trigger_configure()\nspin(managed)",
     "/managed waits in the state inactive: .* /managed activate`"),
    ("managed = LifecycleNode('managed')\nmanaged.create_lifecycle_publisher(Twist, 'x', 1)\n"
     "managed.trigger_configure()\nmanaged.trigger_activate()\nmanaged.trigger_shutdown()\n"
     "spin(managed)", "/managed is in the state finalized, and what it publishes goes out"),
    ("managed = LifecycleNode('managed')\nmanaged.trigger_configure()\n"
     "managed.trigger_activate()\nspin(managed)", ""),
    ("node.set_parameters([rclpy.Parameter('use_sim_time', value=True)])\nspin(node)",
     "/own has use_sim_time, and nothing publishes /clock"),
    ("from rosgraph_msgs.msg import Clock\nnode.create_publisher(Clock, '/clock', 1)\n"
     "node.set_parameters([rclpy.Parameter('use_sim_time', value=True)])\nspin(node)", ""),
    ("from rosgraph_msgs.msg import Clock\n"
     "def late(): timer.cancel(); node.create_publisher(Clock, '/clock', 1)\n"
     "timer = node.create_timer(0.5, late)\n"
     "node.set_parameters([rclpy.Parameter('use_sim_time', value=True)])\nspin(node)", ""),
    (SLEEPS.format(group="None", threads=1),
     r"tick \(node.py, line \d+\) took 1.2 s from 0.50 s on; meanwhile waited: /scan"),
    (SLEEPS.format(group=ALONE, threads=1), "meanwhile waited: /scan"),
    (SLEEPS.format(group=ALONE, threads=2), "meanwhile waited: its own timer"),
    (SLEEPS.format(group=ALONE, threads=2).replace(
        "spin(node, threads=2)", "pool = MultiThreadedExecutor(1); pool.add_node(node)\npool.spin()"
    ), "meanwhile waited: /scan"),
    (SLEEPS.format(group=ALONE, threads=2).replace("0.5,", "1.5,"), ""),
    (SPINS, ""),
    (SPINS.replace("for _ in range(12):", "while rclpy.ok():").replace(
        "timeout_sec=0.1", ""), ""),
    (ASKS.format(client="", timer=""),
     r"ask \(node.py, line \d+\) awaits the answer of /detect from 0.30 s on, but its own"),
    (ASKS.format(client=f", callback_group={ALONE}", timer=""), "the answer of /detect from"),
    (ASKS.format(client="", timer=f", callback_group={ALONE}"), ""),
    ("async def on_scan(scan): await rclpy.task.Future()\n"
     "node.create_subscription(LaserScan, '/scan', on_scan, 10)\nspin(node)",
     r"on_scan \(node.py, line \d+\) has awaited something for 2.0 s from .*: /scan$"),
    ("lock = threading.Lock()\n"
     "def keep(scan): lock.acquire()\n"
     "node.create_subscription(LaserScan, '/scan', keep, 10)\nspin(node, threads=2)",
     r"keep \(node.py, line \d+\) waits there to the end, from 0.\d+ s on"),
    ("def ask(scan): rclpy.spin_until_future_complete(node, rclpy.task.Future())\n"
     "node.create_subscription(LaserScan, '/scan', ask, 10)\nspin(node)",
     r"ask \(node.py, line \d+\) spins in a callback to the end, from 0.\d+ s on"),
    ("event = threading.Event()\n"
     "threading.Timer(1.5, event.set).start()\n"
     "node.create_subscription(LaserScan, '/scan', lambda scan: event.wait(), 10)\n"
     "spin(node, threads=2)", r"<lambda> \(node.py, line \d+\) took 1.\d s from 0.\d+ s on"),
    (THREADS.format(start="threading.Thread(target=work).start()"),
     r"tick \(node.py, line \d+\) started 1\d threads in 2 s"),
    (THREADS.format(start="pass"), ""),
    (FOR_LONG.format("time.sleep(10000)"),
     r"tick \(node.py, line \d+\) waits there to the end, from 0.10 s on, for a moment that did"),
    (FOR_LONG.format("time.sleep(12)"), "waits there to the end"),
    (FOR_LONG.format("threading.Event().wait(0.05)"), ""),
    (FOR_LONG.format("time.sleep(1.0); time.sleep(9.5)"), ""),
    ("import numpy as np; from std_msgs.msg import Bool\n"
     "pub = node.create_publisher(Bool, '/near', 1)\n"
     "node.create_timer(0.1, lambda: pub.publish(Bool(data=np.True_)))\nspin(node)",
     r"on /near `data` of Bool takes boolean, and was given np.True_: .* or bool\(…\) for"),
    ("node.create_timer(100.0, print)\nspin(node)",
     "nothing was published, and a timer of /own fires after 100 s for the first time"),
    ("node.create_timer(100.0, print)\npublisher = node.create_publisher(Twist, '/cmd_vel', 1)\n"
     "node.create_timer(0.1, lambda: publisher.publish(Twist()))\nspin(node)", ""),
]  # fmt: skip


@pytest.mark.parametrize(("source", "said"), SAID)
def test_a_person_is_told(source: str, said: str, runtime: ForkServer, tmp_path: Path) -> None:
    (tmp_path / "node.py").write_text(HEAD + source, "utf-8")
    late = Discovery(program=(0.1, 0.1), late=1.0, end=(0.004, 0.004))
    scenario = msgspec.structs.replace(short(2.0), faults=Faults(discovery=late))
    recording = run_trial(Submission(tmp_path / "node.py"), scenario, runtime)
    assert recording.outcome.completed, recording.outcome
    found = growth_of(recording)
    assert len(found) == bool(said), found
    assert not said or re.search(said, found[0])


@pytest.mark.parametrize(
    ("yaml", "said"),
    [
        ("owm: {ros__parameters: {speed: 0.3}}", "p.yaml has parameters for /owm, and none for /o"),
        ("fleet: {own: {ros__parameters: {speed: 0.3}}}", "for /fleet/own, and none for /own,"),
        ("other: {ros__parameters: {a: 1}}\n/own: {ros__parameters: {speed: 0.3}}", ""),
        ("/**: {ros__parameters: {speed: 0.3}}", ""),
        (
            "/**: {ros__parameters: {a: 1}}\nown: {ros__parameters: {speed: 1.0, far: {b: 1}}}",
            "no node declares a, far.b, so that has no effect; declared here: speed",
        ),
    ],
)
def test_parameters_for_nobody(yaml: str, said: str, runtime: ForkServer, tmp_path: Path) -> None:
    (tmp_path / "p.yaml").write_text(yaml, "utf-8")
    init = "rclpy.init(args=['--ros-args', '--params-file', 'p.yaml'])"
    text = f"{HEAD}\nnode.declare_parameter('speed', 0.1)\nspin(node)".replace("rclpy.init()", init)
    (tmp_path / "node.py").write_text(text, "utf-8")
    recording = run_trial(find_submission(tmp_path / "node.py"), short(0.5), runtime)
    assert recording.outcome.completed, recording.outcome
    found = growth_of(recording)
    assert [said in line for line in found] == [True] * bool(said), found


def test_who_asks_a_model_at_the_end_does_not_wait_for_good(forkserver: ForkServer) -> None:
    exercise = find_exercise("latency_monitor")
    scenario = msgspec.structs.replace(load_scenario("latency_clip"), duration=6.0)
    file = Submission(exercise.solutions / exercise.files[0])
    recording = run_trial(file, scenario, forkserver)
    assert recording.inferences[-1].answered / 1e9 > 6.0
    assert [note.kind for note in recording.notes if note.kind == "waits"] == []


def test_a_note_is_of_the_students_files_and_true_at_the_end() -> None:
    recorder, scenario = Recorder(), load_scenario("detect_silent_server")
    kept = Note("threads", "ask", "detection_client.py, line 3", 39)
    recorder.note([
        kept,
        Note("threads", "detect", "detection_double.py, line 3", 39),
        Note("waits", "ask", "detection_client.py, line 4", 0, time=0, lasted=5 * 10**9),
    ])  # fmt: skip
    end = Outcome("completed", at=scenario.duration)
    recording = recorder.freeze(Simulation(scenario), end)
    assert recording.notes == (kept,)
