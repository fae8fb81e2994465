"""Several programs in one host: each has its own rclpy, all share one robot and one time."""

from pathlib import Path

import numpy as np
import pytest

from rclpy_virtual_time.host.frames import ProgramStart
from rclpy_virtual_time.link.hosts import ForkServer
from rclpy_virtual_time.link.programs import ProgramsRun
from rclpy_virtual_time.link.settings import EPOCH
from rclpy_virtual_time.tests.runs import PREAMBLE, end_of, run_beside_lidar, said, sent, times

READS = "hypothesis.internal.observability"  # reads a clock when it is imported
SERVER = """
from std_srvs.srv import Trigger
class Server(Node):
    def __init__(self):
        super().__init__('server')
        self.create_service(Trigger, '/ask', self.on_ask)
    def on_ask(self, request, response):
        response.success, response.message = True, 'yes'
        return response
def main(args=None):
    rclpy.init(args=args)
    rclpy.spin(Server())
if __name__ == '__main__':
    main()
"""
CLIENT = """
from std_srvs.srv import Trigger
class Client(Node):
    def __init__(self):
        super().__init__('client')
        self.role = self.declare_parameter('role', '?').value
        self.publisher = self.create_publisher(String, f'/{self.role}/answer', 10)
        self.client = self.create_client(Trigger, '/ask')
        self.create_timer(0.1, self.on_timer)
    def on_timer(self):
        if self.client.service_is_ready():
            self.client.call_async(Trigger.Request()).add_done_callback(self.on_answer)
    def on_answer(self, future):
        self.publisher.publish(String(data=future.result().message))
def main(args=None):
    rclpy.init(args=args)
    rclpy.spin(Client())
if __name__ == '__main__':
    main()
"""


def client(role: str, **when: int) -> ProgramStart:
    words = ("--ros-args", "-r", f"__node:={role}_client", "-p", f"role:={role}")
    return ProgramStart("client.py", words, **when)


def run(
    forkserver: ForkServer, folder: Path, *programs: str | ProgramStart, client_source: str = CLIENT
) -> ProgramsRun:
    (folder / "server.py").write_text(PREAMBLE + SERVER)
    (folder / "client.py").write_text(PREAMBLE + client_source)
    return run_beside_lidar(forkserver, folder, *programs, seconds=3.0)


def test_clients_have_their_own_names_and_parameters(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    recording = run(forkserver, tmp_path, "server.py", client("left"), client("right"))

    assert end_of(recording) == "completed", recording
    assert {e.node for e in recording.endpoints} == {"/server", "/left_client", "/right_client"}
    for role in ("left", "right"):
        np.testing.assert_allclose(times(recording, f"/{role}/answer"), np.arange(1, 30) / 10)


def test_what_imports_read_of_clocks_is_not_the_programs(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    source = PREAMBLE + SERVER.replace("super().__init__('server')", "print(time.time_ns())\n"
                                       "        super().__init__('server')")  # fmt: skip
    for name in ("server.py", "client.py"):
        (tmp_path / name).write_text(source)
    both = "server.py", "client.py"
    with ForkServer(EPOCH, libraries=(READS,)) as other:
        runs = [
            run_beside_lidar(each, tmp_path, *both, seconds=0.5) for each in (forkserver, other)
        ]
    first, second = ([line.text for line in each.log] for each in runs)
    assert len(first) == 2
    assert first == second


def test_a_server_can_be_killed_and_come_back(forkserver: ForkServer, tmp_path: Path) -> None:
    first, second = (
        ProgramStart("server.py", stop=950_000_000), ProgramStart("server.py", start=2_050_000_000)
    )  # fmt: skip
    recording = run(forkserver, tmp_path, client("left"), first, second)

    assert end_of(recording) == "completed", recording
    answered = times(recording, "/left/answer")
    np.testing.assert_allclose(answered, [*np.arange(1, 10) / 10, *np.arange(22, 30) / 10])


def test_a_killed_program_leaves_the_others_their_topics(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    """The bridge's node is made by whoever comes first, and must not die with it."""
    recording = run(
        forkserver, tmp_path, client("left", stop=950_000_000), "server.py", client("right")
    )

    assert end_of(recording) == "completed", recording
    assert times(recording, "/left/answer")[-1] < 0.95
    np.testing.assert_allclose(times(recording, "/right/answer"), np.arange(1, 30) / 10)


def test_several_programs_are_as_deterministic_as_one(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    programs = (
        ProgramStart("server.py", stop=1_500_000_000), client("left"),
        client("right", start=400_000_000),
    )  # fmt: skip

    first, second = (run(forkserver, tmp_path, *programs) for _ in range(2))
    assert first == second


def test_a_program_that_ends_by_itself_ends_the_trial(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    crash = CLIENT.replace("if self.client.service_is_ready():", "if 1 / 0:")
    recording = run(forkserver, tmp_path, "server.py", client("a"), client_source=crash)

    assert end_of(recording) == "exception"
    assert recording.ended.text.startswith("client.py: ZeroDivisionError")


SPARE = "{what}\nclass Spare(Node): pass\nrclpy.init()\nSpare('spare')\n{how}\n"
ENDS = {
    "returns": ("", "", 0.0, "the program ran to its end"),
    "raises": ("", "time.sleep(0.5)\n1 / 0", 0.5, "ZeroDivisionError: div"),
    "kills itself": ("", "os.kill(os.getpid(), 15)", 0.0, "its process ended"),
    "cannot be read": ("def (:", "", 0.0, "SyntaxError"),
    "shuts down": (
        "",
        "rclpy.get_default_context().on_shutdown(lambda: print('hi'))\ntime.sleep(0.3)\n"
        "rclpy.try_shutdown()\nrclpy.init()\nrclpy.shutdown()\n"
        "print('ok' if rclpy.get_default_context().ok() else 'bye')",
        0.3, "",
    ),
    "leaves its threads": (
        "import atexit, concurrent.futures as futures",
        "atexit.register(print, 'bye')\n"
        "pool = futures.ThreadPoolExecutor()\npool.submit(print, 'hi').result()\n"
        "threading.Thread(target=time.sleep, args=(100,), daemon=True).start()",
        0.0, "",
    ),
}  # fmt: skip
STAYS = """
import atexit
from concurrent.futures import ThreadPoolExecutor
atexit.register(print, 'never')
class Stays(Echo):
    def __init__(self):
        super().__init__()
        self.pool = ThreadPoolExecutor()
        self.create_timer(0.8, self.on_timer)
    def on_timer(self):
        self.pool.submit(print, self.get_node_names(), self.count_publishers('/cmd_vel')).result()
rclpy.init()
rclpy.get_default_context().on_shutdown(lambda: print('never'))
node = Stays()
while rclpy.ok():
    rclpy.spin_once(node)
"""


def launched(forkserver: ForkServer, folder: Path, **sources: str) -> ProgramsRun:
    """Run programs that start together, as a launch file has them."""
    for name, source in sources.items():
        (folder / f"{name}.py").write_text(PREAMBLE + source)
    programs = [ProgramStart(f"{name}.py", spared=True) for name in sources]
    return run_beside_lidar(forkserver, folder, *programs, seconds=1.0)


@pytest.mark.parametrize("name", ENDS)
def test_one_of_several_that_ends_leaves_the_others_alone(
    name: str, runtime: ForkServer, tmp_path: Path
) -> None:
    what, how, when, why = ENDS[name]
    spare = SPARE.format(what=what, how=how)
    recording = launched(runtime, tmp_path, stays=STAYS, spare=spare)

    assert end_of(recording) == "completed", recording
    (note,) = (note for note in recording.notes.values() if note.kind == "ended")
    assert (note.about, note.time / 1e9) == ("spare.py", pytest.approx(when, abs=0.05))
    assert note.more.startswith(why), note
    assert len(sent(recording, "/cmd_vel")) == 10
    words = said(recording)
    assert words[-1] == "['echo', 'mock_robot'] 1"
    assert words[:-1] == (["hi", "bye"] if "bye" in how else [])
    assert ("1 / 0" in how) == any(line.text.startswith("ZeroDiv") for line in recording.log)


def test_the_last_of_several_ends_the_trial(forkserver: ForkServer, tmp_path: Path) -> None:
    recording = launched(forkserver, tmp_path, one="time.sleep(0.5)", two="")
    assert (end_of(recording), recording.now) == ("returned", 500_000_000)
    assert recording.ended.text.startswith("one.py: ")
