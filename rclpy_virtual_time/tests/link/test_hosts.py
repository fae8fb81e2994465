"""Hosts and the fork server they come from: who they run as, and that nothing of them stays."""

import contextlib
import os
import textwrap
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from rclpy_virtual_time.host.sandbox.layers import CALLS, LAYERS
from rclpy_virtual_time.host.sandbox.users import USERS
from rclpy_virtual_time.link import hosts
from rclpy_virtual_time.link.errors import EngineError
from rclpy_virtual_time.link.exchange import HostDied
from rclpy_virtual_time.link.hosts import ForkServer
from rclpy_virtual_time.link.programs import ProgramsRun
from rclpy_virtual_time.link.ros_environment import RosEnvironment
from rclpy_virtual_time.link.scratch import fresh_folder
from rclpy_virtual_time.link.settings import EPOCH
from rclpy_virtual_time.tests.ordinary import NOBODY, said_by_ordinary
from rclpy_virtual_time.tests.runs import PREAMBLE, RunNode, end_of, is_over, run_beside_lidar

ECHO = "rclpy.init(); rclpy.spin(Echo())"
root_only = pytest.mark.skipif(os.getuid() != 0, reason="only root can become another user")


@pytest.fixture
def own_forkserver() -> Iterator[ForkServer]:
    with ForkServer(EPOCH) as forkserver:
        yield forkserver


@pytest.fixture
def echo(tmp_path: Path) -> Path:
    """A folder with a node."""
    (tmp_path / "echo.py").write_text(PREAMBLE + ECHO)
    return tmp_path


def run(forkserver: ForkServer, folder: Path, seconds: float) -> ProgramsRun:
    return run_beside_lidar(forkserver, folder, "echo.py", seconds=seconds)


def descriptors(pid: int | str = "self") -> int:
    return len(os.listdir(f"/proc/{pid}/fd"))


def children(pid: int) -> list[str]:
    return Path(f"/proc/{pid}/task/{pid}/children").read_text().split()


# --- nothing stays -------------------------------------------------------------------------------

ENDS = (
    ECHO,
    "rclpy.init(); Echo()",
    "os._exit(3)",
    "os.kill(os.getpid(), 9)",
    "os.closerange(3, 30); time.sleep(0.001)",
    "1 / 0",
)


@pytest.mark.long
def test_fifty_trials_leave_no_process_and_no_descriptor(
    own_forkserver: ForkServer, tmp_path: Path
) -> None:
    forkserver = own_forkserver._process.pid
    for number, source in enumerate(ENDS):
        (tmp_path / f"node_{number}.py").write_text(PREAMBLE + source)
    counts = []
    for round_ in range(2):
        for number in range(50 * round_):
            with contextlib.suppress(HostDied):
                file = f"node_{number % len(ENDS)}.py"
                run_beside_lidar(own_forkserver, tmp_path, file, seconds=0.05)
        with fresh_folder() as place, own_forkserver.host(place):
            # within a host: the fork server has buried all those before it
            counts.append((descriptors(), descriptors(forkserver), len(children(forkserver))))

    assert counts[0] == counts[1]
    assert counts[0][2] == 1
    assert not any(pid in children(os.getpid()) for pid in children(forkserver))


def test_a_forkserver_ends_with_its_block(echo: Path) -> None:
    before = descriptors()
    for used in (True, False):
        with ForkServer(EPOCH) as forkserver:
            if used:
                run(forkserver, echo, 0.05)
            pid = forkserver._process.pid
        assert descriptors() == before
        assert not Path(f"/proc/{pid}").exists()


def test_what_a_node_starts_ends_with_it(echo: Path) -> None:
    """Where the kernel has no seccomp, a node can start processes, and hide them in a session.

    There only root can find them again: they are the user's own.
    """
    hide = "os.setsid()" if os.getuid() == 0 else ""
    source = f"""
        pid = os.fork()
        if not pid:
            {hide}
            while True: pass
        print(pid)
        rclpy.init(); rclpy.spin(Echo())
    """
    (echo / "echo.py").write_text(PREAMBLE + textwrap.dedent(source))
    layers = [layer for layer in LAYERS if layer != CALLS]
    with ForkServer(EPOCH, layers=layers) as forkserver:
        recording = run(forkserver, echo, 0.5)

    (line,) = recording.log
    with contextlib.suppress(ProcessLookupError):
        assert is_over(os.pidfd_open(int(line.text)))


# --- many at once --------------------------------------------------------------------------------


def test_many_hosts_at_once(forkserver: ForkServer, echo: Path) -> None:
    with ThreadPoolExecutor(8) as pool:
        trials = [pool.submit(run, forkserver, echo, 0.5) for _ in range(12)]
        recordings = [trial.result() for trial in trials]

    assert {end_of(recording) for recording in recordings} == {"completed"}
    assert all(recording == recordings[0] for recording in recordings)


def test_a_host_that_says_nothing_does_not_hold_up_others(
    forkserver: ForkServer, echo: Path
) -> None:
    with fresh_folder() as folder, forkserver.host(folder):  # nobody tells it what to run
        assert end_of(run(forkserver, echo, 0.2)) == "completed"


# --- faults --------------------------------------------------------------------------------------


def faulty(forkserver: ForkServer, echo: Path) -> str:
    with pytest.raises(EngineError) as caught:
        run(forkserver, echo, 0.1)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_dead_forkserver_is_the_graders_fault(own_forkserver: ForkServer, echo: Path) -> None:
    run(own_forkserver, echo, 0.05)
    own_forkserver._process.kill()
    own_forkserver._process.wait()
    before = descriptors()

    assert "no host for the node" in faulty(own_forkserver, echo)
    assert "no host for the node" in faulty(own_forkserver, echo)
    assert descriptors() == before
    with ForkServer(EPOCH) as young:
        young._process.kill()
        assert "no host for nodes" in faulty(young, echo)


def test_ros_that_can_not_be_imported_is_the_graders_fault(echo: Path, tmp_path: Path) -> None:
    (tmp_path / "rclpy").mkdir()
    (tmp_path / "rclpy" / "__init__.py").write_text("raise ImportError('as I said')")
    broken = RosEnvironment("wheels", (tmp_path,), (), ())
    os.chmod(tmp_path, 0o755)
    with ForkServer(EPOCH, broken) as forkserver:
        assert faulty(forkserver, echo).startswith("no host for nodes: ")


@pytest.mark.parametrize("used, heard", [([1.0, 2.0], True), ([1.0, 1.0], False)])
def test_a_start_may_take_long_as_long_as_it_gets_on(
    monkeypatch: pytest.MonkeyPatch, used: list[float], heard: bool
) -> None:
    monkeypatch.setattr(hosts, "FORK_SERVER_START", 1e-9)  # [s]
    with ForkServer(EPOCH) as forkserver:
        control = forkserver._control

        def cpu_time(pid: int) -> float:
            if len(used) == 1:
                control.settimeout(60.0)
            return used.pop(0)

        monkeypatch.setattr(hosts.real_clock, "cpu_time", cpu_time)
        with contextlib.nullcontext() if heard else pytest.raises(EngineError, match="very busy"):
            assert forkserver.layers


@root_only
def test_a_closed_folder_for_temporary_files_is_the_machines_fault(
    forkserver: ForkServer, echo: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    os.chmod(tmp_path, 0o700)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))

    assert "set TMPDIR" in faulty(forkserver, echo)


# --- who nodes run as ----------------------------------------------------------------------------

WHO = """
import stat
files = [f'/proc/self/fd/{fd}' for fd in range(3, 30)]
sockets = sum(stat.S_ISSOCK(os.stat(file).st_mode) for file in files if os.path.exists(file))
print(os.getuid(), os.getgid(), os.getgroups(), sorted(os.environ), sockets)
rclpy.init(); rclpy.spin(Echo())
"""


@root_only
def test_of_root_nothing_is_left_and_every_host_is_another_user(
    run_node: RunNode, forkserver: ForkServer
) -> None:
    """So one can't signal its neighbours, and each has a limit on processes of its own."""
    recording, other = (run_node(WHO, 0.1) for _ in range(2))
    uid, gid, groups, *rest = recording.log[0].text.split(" ")
    assert uid != other.log[0].text.split(" ")[0]
    assert "a user of its own" in forkserver.isolation

    assert int(uid) == int(gid) in USERS
    assert groups == "[]"
    assert rest[-1] == "0", "a socket to the forkserver or the judge is open"
    assert "SUDO" not in recording.log[0].text
    assert "PYTEST" not in recording.log[0].text


def test_limits_are_set(run_node: RunNode) -> None:
    recording = run_node(
        """
        import resource
        for name in ('CORE', 'FSIZE', 'NOFILE', 'DATA'):
            print(name, *resource.getrlimit(getattr(resource, f'RLIMIT_{name}')))
        rclpy.init(); rclpy.spin(Echo())
        """,
        0.1,
    )

    limits = {line.text.split()[0]: line.text.split()[1:] for line in recording.log}
    assert limits["CORE"] == ["0", "0"]
    assert all(soft == hard != "-1" for soft, hard in limits.values())


ORDINARY = """
import json, os, tempfile
from pathlib import Path
from rclpy_virtual_time.link.hosts import ForkServer
from rclpy_virtual_time.link.settings import EPOCH
from rclpy_virtual_time.tests.runs import PREAMBLE, end_of, run_beside_lidar
with tempfile.TemporaryDirectory() as folder, ForkServer(EPOCH) as forkserver:
    (Path(folder) / 'echo.py').write_text(PREAMBLE + '''
before = os.listdir('/dev/shm')
rclpy.init(); node = Echo(); print(os.getuid())
print(*(f for f in os.listdir('/dev/shm') if 'port' not in f and f not in before))
rclpy.spin(node)
''')
    runs = [run_beside_lidar(forkserver, Path(folder), 'echo.py', seconds=1.0) for _ in range(2)]
    said = [line.text for line in runs[0].log]
    left = set(said[1].split()) & set(os.listdir('/dev/shm'))
    outcomes, (a, b) = {end_of(run) for run in runs}, runs
    same = (a.published, a.endpoints) == (b.published, b.endpoints)
    print(json.dumps([forkserver.isolation, said[0], list(outcomes), same,
                      len(a.published), bool(said[1]), sorted(left)]))
"""


def test_an_ordinary_user_can_run_programs() -> None:
    """The judge and its fork server without any privilege."""
    isolation, uid, outcomes, same, published, shared, left = said_by_ordinary(ORDINARY)
    assert "resource limits" in isolation and "user of its own" not in isolation
    assert uid == str(os.getuid() or NOBODY)
    assert (outcomes, same, published) == (["completed"], True, 10)
    assert (shared, left) == (True, [])
