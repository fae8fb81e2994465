"""A reader's cell: its end costs one file, and nothing comes out of it but plain data."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cell_works
import pytest

from rclpy_virtual_time.link import cell
from rclpy_virtual_time.link.cell import MIB, Broken, FileReader, Refused
from rclpy_virtual_time.tests.ordinary import said_by_ordinary

READER = FileReader(memory=128 * MIB, cpu=1, file=MIB // 2, answer=MIB)
ENDS: dict[str, tuple[Callable[..., Any], tuple[Any, ...], Any, str]] = {
    "refusal": (cell_works.refuse, ("no",), None, "^no$"),
    "exception": (cell_works.fail, ("x" * 10**6,), None, "^ValueError: x+$"),
    "memory": (cell_works.take_memory, (), int, "more than 128 MiB of memory"),
    "time": (cell_works.spin, (), None, "more than 1 s of CPU time"),
    "crash": (cell_works.crash, (), None, "ends its reader .SIGSEGV"),
    "silence": (cell_works.end, (), None, "no valid answer"),
    "too much": (cell_works.say, (2 * MIB,), bytes, "more in it than the 1 MiB"),
    "another type": (cell_works.lie, (), dict[str, list[str]], "no valid answer"),
    "no message": (cell_works.forge, (), None, "no valid answer"),
}


@pytest.fixture(autouse=True, scope="module")
def own_server() -> None:
    """Have a server that has imported nothing for other tests: its memory counts."""
    cell._servers.close()


@pytest.mark.parametrize("name", ENDS)
def test_an_end_costs_one_file_with_a_reason(name: str, tmp_path: Path) -> None:
    work, arguments, returns, reason = ENDS[name]
    with pytest.raises(Refused, match=reason) as ended:
        READER.read(work, *arguments, returns=returns)
    assert len(str(ended.value)) < 1_000
    assert isinstance(ended.value, Broken) == (name == "exception")
    (tmp_path / "next").write_bytes(b"1234")
    assert FileReader().read(cell_works.size, file=tmp_path / "next", returns=int) == 4


TRY = """
import json, sys, tempfile, os
from pathlib import Path
sys.path.insert(0, {here!r})
import cell_works
from rclpy_virtual_time.link.cell import FileReader
folder = Path(tempfile.mkdtemp())
(folder / "room").mkdir()
(folder / "secret").write_text("the course's secret")
os.environ["SECRET"] = "x"
print(json.dumps(FileReader(file=1000).read(cell_works.attempts, str(folder / "secret"),
    room=folder / "room", returns=list[str])))
"""


@pytest.mark.parametrize("user", ["this one", "an ordinary one"])
def test_nothing_but_its_own_folder_is_in_reach(user: str) -> None:
    script = TRY.format(here=str(Path(__file__).parent))
    if user == "this one":
        said = subprocess.run(
            [sys.executable, "-c", script], capture_output=True, check=True, timeout=120
        )
        assert json.loads(said.stdout) == ["own folder"]
    else:
        assert said_by_ordinary(script) == ["own folder"]


@pytest.mark.skipif(sys.platform != "linux", reason="cells are of Linux")
def test_links_and_pipes_are_not_opened(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("/etc/passwd")
    os.mkfifo(tmp_path / "pipe")
    for name in ("link", "pipe", "missing"):
        with pytest.raises(OSError):
            FileReader().read(cell_works.size, file=tmp_path / name, returns=int)


WAIT = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background ignores it
sys.path.insert(0, {here!r})
import cell_works
from rclpy_virtual_time.link.cell import FileReader
FileReader().read(cell_works.lie, returns=dict[str, list[int]])
try:
    print("reading", flush=True)
    FileReader(cpu=600).read(cell_works.spin, returns=None)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


def test_control_c_ends_a_reader_at_once() -> None:
    script = WAIT.format(here=str(Path(__file__).parent))
    with subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, text=True
    ) as judge:
        assert judge.stdout is not None
        assert judge.stdout.readline() == "reading\n"
        judge.send_signal(signal.SIGINT)
        assert judge.stdout.readline() == "interrupted\n"
        assert judge.wait(timeout=60) == 0
