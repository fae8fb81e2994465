"""Several programs in one host: each has its own rclpy, all share one robot and one time."""

from pathlib import Path

import msgspec
import numpy as np
import pytest
from node_runs import PREAMBLE, short

from grader.course.submission import Package, Program, Submission
from grader.launchers import fork_server
from grader.recording import Recording, ended_of
from grader.trial.virtual_time import run_trial
from rclpy_virtual_time.link.hosts import ForkServer
from sim.scenario import ProgramSpec

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


def client(role: str, **times: float) -> ProgramSpec:
    words = ("--ros-args", "-r", f"__node:={role}_client", "-p", f"role:={role}")
    return ProgramSpec("client.py", arguments=words, **times)


def run(
    forkserver: ForkServer, folder: Path, *programs: ProgramSpec, client_source: str = CLIENT
) -> Recording:
    (folder / "server.py").write_text(PREAMBLE + SERVER)
    (folder / "client.py").write_text(PREAMBLE + client_source)
    scenario = msgspec.structs.replace(short(3.0), program=programs)
    submission = Submission(folder / "server.py", others=(folder / "client.py",))
    return run_trial(submission, scenario, forkserver)


def test_clients_have_their_own_names_and_parameters(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    server = ProgramSpec("server.py")
    recording = run(forkserver, tmp_path, server, client("left"), client("right"))

    assert recording.outcome.completed, recording.outcome
    assert {e.node for e in recording.endpoints} == {"/server", "/left_client", "/right_client"}
    for role in ("left", "right"):
        np.testing.assert_allclose(recording.times(f"/{role}/answer"), np.arange(1, 30) / 10)


def test_what_imports_read_of_clocks_is_not_the_programs(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    source = PREAMBLE + SERVER.replace("super().__init__('server')", "print(time.time_ns())\n"
                                       "        super().__init__('server')")  # fmt: skip
    for name in ("server.py", "client.py"):
        (tmp_path / name).write_text(source)
    scenario = msgspec.structs.replace(
        short(0.5), program=(ProgramSpec("server.py"), ProgramSpec("client.py"))
    )
    submission = Submission(tmp_path / "server.py", others=(tmp_path / "client.py",))
    with fork_server(libraries=(READS,)) as other:
        runs = [run_trial(submission, scenario, each) for each in (forkserver, other)]
    first, second = ([line.text for line in each.log] for each in runs)
    assert len(first) == 2
    assert first == second


def test_a_server_can_be_killed_and_come_back(forkserver: ForkServer, tmp_path: Path) -> None:
    first, second = ProgramSpec("server.py", stop=0.95), ProgramSpec("server.py", start=2.05)
    recording = run(forkserver, tmp_path, client("left"), first, second)

    assert recording.outcome.completed, recording.outcome
    times = recording.times("/left/answer")
    np.testing.assert_allclose(times, [*np.arange(1, 10) / 10, *np.arange(22, 30) / 10])


def test_a_killed_program_leaves_the_others_their_topics(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    """The bridge's node is made by whoever comes first, and must not die with it."""
    recording = run(
        forkserver, tmp_path, client("left", stop=0.95), ProgramSpec("server.py"), client("right")
    )

    assert recording.outcome.completed, recording.outcome
    assert recording.times("/left/answer")[-1] < 0.95
    np.testing.assert_allclose(recording.times("/right/answer"), np.arange(1, 30) / 10)


def test_a_missing_file_is_named(forkserver: ForkServer, tmp_path: Path) -> None:
    scenario = msgspec.structs.replace(short(1.0), program=(client("left"),))
    (tmp_path / "server.py").write_text(PREAMBLE + SERVER)
    recording = run_trial(Submission(tmp_path / "server.py"), scenario, forkserver)

    assert recording.outcome.kind == "missing"
    assert recording.outcome.text == "there is no client.py in the submission, only server.py"


def test_several_programs_are_as_deterministic_as_one(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    programs = (ProgramSpec("server.py", stop=1.5), client("left"), client("right", start=0.4))

    assert len({run(forkserver, tmp_path, *programs).digest() for _ in range(2)}) == 1


def test_a_program_that_ends_by_itself_ends_the_trial(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    crash = CLIENT.replace("if self.client.service_is_ready():", "if 1 / 0:")
    recording = run(
        forkserver, tmp_path, ProgramSpec("server.py"), client("a"), client_source=crash
    )

    assert recording.outcome.kind == "exception"
    assert recording.outcome.text.startswith("client.py: ZeroDivisionError")


SPARE = "{what}\nclass Spare(Node): pass\nrclpy.init()\nSpare('spare')\n{how}\n"
ENDS = {
    "returns": ("", "", "spare.py ended at 0.0 s: the program ran to its end;"),
    "raises": ("", "time.sleep(0.5)\n1 / 0", "spare.py ended at 0.5 s: ZeroDivisionError: div"),
    "kills itself": ("", "os.kill(os.getpid(), 15)", "spare.py ended at 0.0 s: its process ended"),
    "cannot be read": ("def (:", "", "spare.py ended at 0.0 s: SyntaxError"),
    "shuts down": (
        "",
        "rclpy.get_default_context().on_shutdown(lambda: print('hi'))\ntime.sleep(0.3)\n"
        "rclpy.try_shutdown()\nrclpy.init()\nrclpy.shutdown()\n"
        "print('ok' if rclpy.get_default_context().ok() else 'bye')",
        "spare.py ended at 0.3 s",
    ),
    "leaves its threads": (
        "import atexit, concurrent.futures as futures",
        "atexit.register(print, 'bye')\n"
        "pool = futures.ThreadPoolExecutor()\npool.submit(print, 'hi').result()\n"
        "threading.Thread(target=time.sleep, args=(100,), daemon=True).start()",
        "spare.py ended at 0.0 s",
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


def launched(folder: Path, **sources: str) -> Submission:
    """Return a package whose programs start together, as a launch file has them."""
    for name, source in sources.items():
        (folder / f"{name}.py").write_text(PREAMBLE + source)
    files = {f"{name}.py": folder / f"{name}.py" for name in sources}
    package = Package(programs=tuple(map(Program, files)))
    return Submission(next(iter(files.values())), beside=files, package=package)


@pytest.mark.parametrize("name", ENDS)
def test_one_of_several_that_ends_leaves_the_others_alone(
    name: str, runtime: ForkServer, tmp_path: Path
) -> None:
    what, how, said = ENDS[name]
    submission = launched(tmp_path, stays=STAYS, spare=SPARE.format(what=what, how=how))
    recording = run_trial(submission, short(1.0), runtime)

    assert recording.outcome.completed, recording.outcome
    (note,) = ended_of(recording)
    assert note.startswith(said), note
    assert len(recording.twists().t) == 10
    words = [line.text for line in recording.log if line.level == "stdout"]
    assert words[-1] == "['echo', 'mock_robot'] 1"
    assert words[:-1] == (["hi", "bye"] if "bye" in how else [])
    assert ("1 / 0" in how) == any(line.text.startswith("ZeroDiv") for line in recording.log)


def test_the_last_of_several_ends_the_trial(forkserver: ForkServer, tmp_path: Path) -> None:
    submission = launched(tmp_path, one="time.sleep(0.5)", two="")
    recording = run_trial(submission, short(1.0), forkserver)
    assert (recording.outcome.kind, recording.outcome.at) == ("returned", 0.5)
    assert recording.outcome.text.startswith("one.py: ")
