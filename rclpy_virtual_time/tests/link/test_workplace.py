"""What a host may take of the machine: its folder, its threads; as root and as ordinary user."""

import functools
import os
import subprocess
import sys
import tempfile
import textwrap
from collections.abc import Iterator
from pathlib import Path

import pytest

from rclpy_virtual_time.host.sandbox.amounts import MAX_FOLDER, MAX_FOLDER_FILES
from rclpy_virtual_time.host.sandbox.layers import MOUNTS
from rclpy_virtual_time.link.errors import EngineError
from rclpy_virtual_time.link.hosts import ForkServer
from rclpy_virtual_time.link.scratch import fresh_folder
from rclpy_virtual_time.link.workplace import Excess, check_folder
from rclpy_virtual_time.tests.ordinary import OUT_OF_REACH, ROOT, run_as_ordinary, said_by_ordinary
from rclpy_virtual_time.tests.runs import PREAMBLE, end_of, is_over, run_beside_lidar

LONG = functools.partial(pytest.param, marks=pytest.mark.long)
SPIN = "\nrclpy.init(); rclpy.spin(Echo())\n"
GREEDY = {  # each says how much it got
    "unlinked": """
got, held = 0, []
try:
    for number in range(8):
        held.append(os.open('file', os.O_CREAT | os.O_WRONLY)); os.unlink('file')
        os.posix_fallocate(held[-1], 0, 60 << 20); got += 60 << 20
except OSError as error: print(error.strerror)
print(got)
""",
    "files": """
got = 0
try:
    for got in range(1, 6_000): os.close(os.open(f"file-{got}", os.O_CREAT | os.O_WRONLY))
except OSError as error: print(error.strerror)
print(got)
""",
    "threads": """
import ctypes
libc, attributes, thread, got = ctypes.CDLL(None), (ctypes.c_char * 64)(), ctypes.c_ulong(), 0
libc.pthread_attr_init(attributes)
libc.pthread_attr_setstacksize(attributes, ctypes.c_size_t(65536))
sleep = ctypes.cast(libc.sleep, ctypes.c_void_p)
while got < 700 and not libc.pthread_create(
    ctypes.byref(thread), attributes, sleep, ctypes.c_void_p(1000)
): got += 1
print(got)
""",
}  # fmt: skip
MOST = {"unlinked": MAX_FOLDER, "files": MAX_FOLDER_FILES, "threads": 512}
SCENE = """
import json, sys, tempfile
from pathlib import Path
from rclpy_virtual_time.link.hosts import ForkServer
from rclpy_virtual_time.link.settings import EPOCH
from test_workplace import GREEDY, run
with tempfile.TemporaryDirectory() as folder, ForkServer(EPOCH) as forkserver:
    said = {name: run(name, Path(folder), forkserver) for name in GREEDY}
    print(json.dumps((forkserver.layers, forkserver.means.counted, said)))
"""


def run(name: str, folder: Path, forkserver: ForkServer) -> tuple[str, str, list[str]]:
    """Run a greedy node; say how it ended, with which words, and what it printed."""
    (folder / f"{name}.py").write_text(PREAMBLE + GREEDY[name] + SPIN)
    try:
        run = run_beside_lidar(forkserver, folder, f"{name}.py", seconds=0.3)
    except Excess as excess:
        return "flooded", str(excess), excess.__notes__[0].splitlines()
    return end_of(run), run.ended.text if run.ended else "", [line.text for line in run.log]


# --- the limits ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", GREEDY)
def test_the_kernel_limits_a_host(name: str, forkserver: ForkServer, tmp_path: Path) -> None:
    if MOUNTS not in forkserver.layers or not forkserver.means.counted:
        pytest.skip("no mounts on this machine")
    kind, _, log = run(name, tmp_path, forkserver)

    got = [int(line) for line in log if line.isdigit()]
    assert got and 0 < got[0] <= MOST[name]
    assert kind in ("completed", "flooded", "exception")


@pytest.mark.parametrize("namespaces", [LONG(True), False])
def test_an_ordinary_user_has_limits_too(namespaces: bool) -> None:
    scene = f"sys.path.insert(0, {str(Path(__file__).parent)!r})\n{SCENE}"
    layers, counted, runs = said_by_ordinary(scene, namespaces=namespaces)

    if not namespaces:
        assert (MOUNTS in layers, counted) == (False, False)
    if MOUNTS in layers:
        for name, (kind, _, log) in runs.items():
            got = [int(line) for line in log if line.isdigit()]
            assert kind in ("completed", "flooded", "exception")
            assert got[0] <= MOST[name] or not counted
    else:
        assert {kind for kind, _, _ in runs.values()} == {"flooded"}
        assert "threads" in runs["threads"][1]
        assert "more than 5,000 files or 268,435,456 bytes" in runs["files"][1]


def test_a_folder_that_is_too_deep_is_an_excess() -> None:
    before = Path.cwd()
    with fresh_folder() as folder:
        os.chdir(folder)
        depth = 0
        try:
            for _ in range(3_000):
                os.mkdir("deep")
                os.chdir("deep")
                depth += 1
            with pytest.raises(Excess, match="folders in one another"):
                check_folder(folder)
        finally:
            for _ in range(depth):  # whoever cleans up later would recurse too deep
                os.chdir("..")
                os.rmdir("deep")
            os.chdir(before)


# --- what has to work all the same ---------------------------------------------------------------


def test_files_survive_for_the_next_host_of_a_place(forkserver: ForkServer) -> None:
    """A program that is started again in the same trial finds what it wrote."""
    with fresh_folder() as folder:
        (folder / "node.py").touch()
        (folder / "handed_in.bin").write_bytes(b"model")
        (folder / "below").mkdir()
        (folder / "below" / "link").symlink_to("../handed_in.bin")
        with forkserver.workplace(folder) as place:
            with forkserver.host(place), forkserver.host(place):
                (place.seen / "written").write_text("here")
            with forkserver.host(place):
                seen = {path.name: path.is_symlink() for path in place.seen.rglob("*")}
                seen.pop(".home", None)  # of a host that has begun by now
                status = (place.seen / "handed_in.bin").stat()
        after = {path.name for path in folder.iterdir()}

    assert seen == {
        "node.py": False, "handed_in.bin": False, "below": False, "link": True,
        "written": False,
    }  # fmt: skip
    assert status.st_uid == (place.user or os.getuid())
    assert ("written" in after) == (not place.limited)


def test_no_mount_stays(forkserver: ForkServer) -> None:
    def mounts(pid: int | str) -> int:
        return len(Path(f"/proc/{pid}/mounts").read_text().splitlines())

    process = forkserver._process.pid
    before = mounts(process), mounts("self"), len(os.listdir("/proc/self/fd"))
    for _ in range(3):
        with fresh_folder() as folder, forkserver.host(folder):
            inside = mounts(process)
    with (
        fresh_folder() as folder,
        forkserver.workplace(folder, limited=False) as place,
        forkserver.host(place),  # it is forked when the last mount has gone
    ):
        pass
    after = mounts(process), mounts("self"), len(os.listdir("/proc/self/fd"))

    assert after == before
    assert (inside > before[0]) == (MOUNTS in forkserver.layers)


def test_a_place_that_is_not_there_is_the_graders_fault(forkserver: ForkServer) -> None:
    if MOUNTS not in forkserver.layers:
        pytest.skip("no mounts on this machine")
    missing = Path("/tmp/course-0-not-there")
    with pytest.raises(EngineError, match=r"no host for the node: .*No such file"):
        forkserver.workplace(missing).__enter__()


# --- nobody outlives the judge -------------------------------------------------------------------

OUTLIVES = """
import ctypes, os, signal
libc = ctypes.CDLL(None)
refused = libc.prctl(1, 0, 0, 0, 0)
for number in range(1, 32):
    try: signal.signal(number, signal.SIG_IGN)
    except OSError: pass
try: os.setsid()
except OSError: pass
print('here', refused, flush=True)
for _ in range(100): libc.usleep(999999)
"""
WAITING = """
import sys
from pathlib import Path
from rclpy_virtual_time.host.frames import ProgramStart, Start
from rclpy_virtual_time.link.hosts import ForkServer
from rclpy_virtual_time.link.link import Link
from rclpy_virtual_time.link.pipes import Pipes
from rclpy_virtual_time.link.scratch import fresh_folder
from rclpy_virtual_time.link.settings import EPOCH

with (
    ForkServer(EPOCH) as forkserver,
    fresh_folder() as folder,
    forkserver.host_process(folder) as host,
):
    (folder / "node.py").write_bytes(Path({file!r}).read_bytes())
    link = Link(Pipes(host))
    print(forkserver._process.pid, host.pid, flush=True)
    try:
        link.run(Start((ProgramStart(str(folder / "node.py")),), EPOCH, 1, ()), 60.0)
    except BaseException as error:
        print(type(error).__name__, flush=True)
    print(host.wait(1.0), flush=True)
"""


@pytest.fixture
def open_folder() -> Iterator[Path]:
    """A folder that others can enter; pytest's own they can't."""
    with tempfile.TemporaryDirectory() as name:
        Path(name).chmod(0o755)
        yield Path(name)


@pytest.mark.parametrize("who", ["root", LONG("ordinary"), LONG("without namespaces")])
@pytest.mark.parametrize("victim", ["judge", LONG("fork server")])
def test_a_host_never_outlives_its_judge(victim: str, who: str, open_folder: Path) -> None:
    file = open_folder / "outlives.py"
    file.write_text(OUTLIVES)
    script = textwrap.dedent(WAITING).format(file=str(file))
    if who == "root":
        judge = subprocess.Popen(
            [sys.executable, "-c", script],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT,
        )  # fmt: skip
    else:
        judge = run_as_ordinary(script, namespaces=who == "ordinary")
    with judge:
        assert judge.stdout is not None and judge.stderr is not None
        line = judge.stdout.readline()
        if not line and OUT_OF_REACH in judge.stderr.read():
            pytest.skip(OUT_OF_REACH)
        forkserver, host = map(int, line.split())
        handles = [os.pidfd_open(host), os.pidfd_open(forkserver)]
        os.kill(judge.pid if victim == "judge" else forkserver, 9)
        said, complaints = judge.communicate(timeout=60)
    over = [is_over(handle) for handle in handles]

    assert over == [True, True]
    if victim == "fork server":  # that is the grader's fault, not the node's
        assert "HostDied" in said
        assert "EngineError: the process that starts hosts has ended" in complaints
