"""The SIGINT at the end of a run, as a person sends it, and what is said in which order."""

import textwrap
from pathlib import Path

import pytest
from node_runs import RunNode, short

from grader.course.exercises import find_exercise
from grader.course.submission import Submission
from grader.trial.virtual_time import run_trial
from rclpy_virtual_time.link.hosts import ForkServer
from sim.scenario_files import load_scenario

SPIN = """
class Drives(Echo):
    def __init__(self):
        super().__init__()
        self.create_timer(0.1, lambda: self.publisher.publish(Twist()))
def free():
    rclpy.init(signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
    return Drives()
"""
GOES_ON = "has not ended after a second"

ENDS = {  # source: kind, problem, what is printed, messages that leave
    "finally": (
        """
        import atexit
        atexit.register(lambda: print("atexit"))
        rclpy.init(); node = Drives()
        rclpy.get_default_context().on_shutdown(lambda: print("never, as on a robot"))
        try: rclpy.spin(node)
        except KeyboardInterrupt: print("interrupted", rclpy.ok())
        finally: node.destroy_node(); rclpy.try_shutdown()
        """,
        ("returned", "", ["interrupted False", "atexit"], 0),
    ),
    "a last command": (
        """
        rclpy.init(); node = Drives()
        try: rclpy.spin(node)
        finally: node.publisher.publish(Twist())
        """,
        ("exception", "call rclpy.try_shutdown()", [], 0),
    ),
    "a second shutdown": (
        """
        rclpy.init()
        try: rclpy.spin(Drives())
        except KeyboardInterrupt: pass
        rclpy.shutdown()
        """,
        ("exception", "already called", [], 0),
    ),
    "own handling": (
        """
        node = free()
        rclpy.get_default_context().on_shutdown(lambda: print("shutdown"))
        try: rclpy.spin(node)
        except KeyboardInterrupt: pass
        node.publisher.publish(Twist()); rclpy.shutdown()
        """,
        ("returned", "", ["shutdown"], 1),
    ),
    "a flag": (
        """
        import signal
        node, asked = free(), []
        signal.signal(signal.SIGINT, lambda *_: asked.append(1))
        while not asked: rclpy.spin_once(node)
        print("asked")
        """,
        ("returned", "", ["asked"], 1),
    ),
    "asyncio": (
        """
        import asyncio, signal
        async def main():
            node, asked = free(), asyncio.Event()
            asyncio.get_running_loop().add_signal_handler(signal.SIGINT, asked.set)
            while not asked.is_set():
                rclpy.spin_once(node, timeout_sec=0)
                await asyncio.sleep(0.05)
            print("asked")
        asyncio.run(main())
        """,
        ("returned", "", ["asked"], 0),
    ),
    "uncaught": ("rclpy.init(); rclpy.spin(Drives())", ("exception", "", [], 0)),
    "exit": (
        """
        import signal
        node = free()
        signal.signal(signal.SIGINT, lambda *_: sys.exit(0))
        rclpy.spin(node)
        """,
        ("exited", "", [], 0),
    ),
    "a thread": (
        """
        def work():
            while True: time.sleep(0.5)
        threading.Thread(target=work).start()
        rclpy.init(); rclpy.spin(Drives())
        """,
        ("running", GOES_ON, [], 0),
    ),
    "ignored": (
        """
        import signal
        node = free()
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        rclpy.spin(node)
        """,
        ("running", GOES_ON, [], 15),
    ),
    "busy": (
        """
        rclpy.init()
        try: rclpy.spin(Drives())
        finally:
            while True: pass
        """,
        ("hung", "computes for more than 2 s", [], 0),
    ),
}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.long if name == "busy" else ()) for name in ENDS]
)
def test_a_program_is_sent_sigint(run_node: RunNode, name: str) -> None:
    source, (kind, problem, said, sent) = ENDS[name]
    recording = run_node(SPIN + textwrap.dedent(source), short(0.5), interrupt=True)
    ending = recording.ending

    assert recording.outcome.completed, recording.outcome
    assert ending is not None
    assert (ending.outcome.kind, len(ending.published)) == (kind, sent), ending
    assert problem in ending.problem if problem else not ending.problem
    assert [line.text for line in ending.log if line.level == "stdout"] == said


def test_the_end_is_not_in_the_record(run_node: RunNode) -> None:
    source = SPIN + textwrap.dedent(ENDS["own handling"][0]) + 'print("bye")'
    with_end, without = (run_node(source, short(0.5), interrupt=each) for each in (True, False))

    assert with_end.digest() == without.digest()
    assert with_end.log == without.log
    assert without.ending is None


def test_what_is_said_at_one_moment_stays_in_order(run_node: RunNode) -> None:
    recording = run_node(
        """
        rclpy.init(); node = Echo()
        for number in range(3):
            print("out", number)
            node.get_logger().info(f"log {number}")
            print("err", number, file=sys.stderr)
            print("in", end=" "); print("parts", number)
        rclpy.spin(node)
        """,
        short(0.2),
    )
    words = [
        f"{kind} {number}" for number in range(3) for kind in ("out", "log", "err", "in parts")
    ]
    assert [line.text for line in recording.log] == words


def test_models_answer_on_after_the_end_and_it_is_not_in_the_record(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    exercise, scenario = find_exercise("slow_model"), load_scenario("slow_leader")
    right = (exercise.solutions / exercise.files[0]).read_text("utf-8")
    asks = "        node.model.predict(np.ones((1, 5)))\n        rclpy.try_shutdown()\n"
    assert right.count("        rclpy.try_shutdown()\n") == 1
    file = tmp_path / exercise.files[0]
    file.write_text(right.replace("        rclpy.try_shutdown()\n", asks), "utf-8")
    with_end, without = (
        run_trial(Submission(file), scenario, forkserver, interrupt=each) for each in (True, False)
    )
    assert with_end.ending is not None
    assert with_end.ending.problem == ""
    assert with_end.digest() == without.digest()
