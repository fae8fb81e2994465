"""Hosts without Linux's means: they end, hang, print and forge, and the judge goes on."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from rclpy_virtual_time.host.frames import Ended, ProgramStart, Run, Settled, Start
from rclpy_virtual_time.link import practice
from rclpy_virtual_time.link.errors import EngineError
from rclpy_virtual_time.link.exchange import HostDied, HostForged, HostHung
from rclpy_virtual_time.link.practice import PracticeServer
from rclpy_virtual_time.link.settings import EPOCH

LIMIT = 60.0  # [s] for answers that come
SPINS = """
import sys, rclpy
from rclpy.node import Node
from std_msgs.msg import String
rclpy.init()
node = Node("talker")
publisher = node.create_publisher(String, "said", 10)
node.create_timer(0.5, lambda: publisher.publish(String(data="x")))
print("out", flush=True)
print("err", file=sys.stderr)
node.get_logger().warning("logged")
rclpy.spin(node)
"""


@pytest.fixture(scope="module")
def server() -> Iterator[PracticeServer]:
    with PracticeServer(EPOCH) as started:
        yield started


def start_of(folder: Path, source: str) -> Start:
    file = folder / "agent.py"
    file.write_text(source, "utf-8")
    return Start((ProgramStart(str(file)),), EPOCH, seed=1, offers=())


def test_a_node_runs_to_a_time_and_its_words_have_times(
    server: PracticeServer, tmp_path: Path
) -> None:
    with server.host(tmp_path) as link:
        first, _ = link.run(start_of(tmp_path, SPINS), LIMIT)
        assert isinstance(first, Settled)
        assert first.now == 0
        answer, cost = link.run(Run(1_200_000_000), LIMIT)
        assert isinstance(answer, Settled) and answer.spinning
        assert [(m.time, m.topic) for m in answer.published] == [
            (500_000_000, "/said"), (1_000_000_000, "/said"),
        ]  # fmt: skip
        assert cost.wall > 0
        said = {(line.level, line.text) for line in link.log()}
        assert said == {("stdout", "out"), ("stderr", "err"), ("warn", "logged")}


def test_a_program_that_ends_says_how(server: PracticeServer, tmp_path: Path) -> None:
    with server.host(tmp_path) as link:
        answer, _ = link.run(start_of(tmp_path, "1 / 0"), LIMIT)
    assert isinstance(answer, Ended)
    assert (answer.kind, answer.text.partition(" (")[0]) == (
        "exception", "ZeroDivisionError: division by zero",
    )  # fmt: skip


def test_what_a_node_puts_in_the_place_of_its_output_is_not_read(
    server: PracticeServer, tmp_path: Path
) -> None:
    source = """import os
print("before", flush=True)
for number, put in ((1, os.mkfifo), (2, lambda path: os.symlink("/dev/zero", path))):
    path = os.readlink(f"/proc/self/fd/{number}")
    os.unlink(path)
    put(path)
"""
    with server.host(tmp_path) as link:
        answer, _ = link.run(start_of(tmp_path, source), LIMIT)
        assert isinstance(answer, Ended)
        assert [line.text for line in link.log()] == ["before"]


def test_a_process_that_goes_is_gone_and_one_that_says_nothing_hangs(
    server: PracticeServer, tmp_path: Path
) -> None:
    with server.host(tmp_path) as link:
        with pytest.raises(HostDied):
            link.run(start_of(tmp_path, "import os; os._exit(7)"), LIMIT)
        assert link.wait(LIMIT) == "exit code 7"
    with server.host(tmp_path) as link:
        with pytest.raises(HostHung):
            link.run(start_of(tmp_path, "while True: pass"), 0.5)
        assert link.wait().startswith("signal")


@pytest.mark.parametrize(
    "bytes_", ["b'\\xff\\xff\\xff\\x7f'", "b'\\x02\\0\\0\\0\\xc1\\xc1'"], ids=["huge", "no frame"]
)
def test_what_a_program_says_in_the_hosts_place_is_refused(
    server: PracticeServer, tmp_path: Path, bytes_: str
) -> None:
    source = f"import os\nfor fd in range(3, 20):\n    try: os.write(fd, {bytes_})\n"
    source += "    except OSError: pass\n"
    with server.host(tmp_path) as link, pytest.raises(HostForged):
        link.run(start_of(tmp_path, source), LIMIT)


def test_a_host_that_can_not_start_says_why(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(practice, "PRELUDE", "raise SystemExit('no such luck')")
    with (
        PracticeServer(EPOCH) as server,
        pytest.raises(EngineError, match="no such luck"),
        server.host(tmp_path),
    ):
        pass
