"""Ports of Fast DDS that a killed process left half made are removed, and no others."""

import mmap
import os
import time
import uuid
from collections.abc import Iterator
from pathlib import Path

import pytest

from rclpy_virtual_time.link import shared_memory
from rclpy_virtual_time.link.shared_memory import SHM, remove_half_made_ports
from rclpy_virtual_time.tests.ordinary import said_by_ordinary

pytestmark = pytest.mark.skipif(not SHM.is_dir(), reason="no /dev/shm here")


@pytest.fixture(params=shared_memory.OURS)
def port(request: pytest.FixtureRequest) -> Iterator[Path]:
    """Return a port that nobody has: Fast DDS's ports end at 65,535."""
    file = SHM / f"{request.param}port9{uuid.uuid4().int % 10**9:09}"
    yield file
    file.unlink(missing_ok=True)


@pytest.mark.parametrize(("word", "removed"), [(b"", True), (b"\0", True), (b"\1", True),
                                               (b"\2", False)])  # fmt: skip
def test_a_port_left_half_made_is_removed_and_one_that_is_ready_stays(
    port: Path, word: bytes, removed: bool
) -> None:
    port.write_bytes(word.ljust(44_208, b"\0") if word else b"")
    lock = port.with_name(f"{port.name}_el")  # it is always empty
    lock.touch()
    try:
        found = remove_half_made_ports()
        assert (port in found, port.exists()) == (removed, not removed)
        assert (lock in found, lock.exists()) == (False, True)
    finally:
        lock.unlink()


def test_a_port_that_somebody_is_making_stays(port: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shared_memory, "MAKING", 600.0)  # [s], on any machine
    with port.open("w+b") as file:
        assert port not in remove_half_made_ports()  # open
        file.write(bytes(4096))
        file.flush()
        mapped = mmap.mmap(file.fileno(), 4096)
    with mapped:
        assert port not in remove_half_made_ports()  # mapped
    assert port in remove_half_made_ports()


@pytest.mark.parametrize("age", [3600.0, -3600.0])
def test_a_port_that_others_only_wait_for_is_removed(port: Path, age: float) -> None:
    """Its maker would be done by now."""
    with port.open("w+b"):
        os.utime(port, (time.time() - age, time.time() - age))

        assert port in remove_half_made_ports()


SHARED = """
import json, os, tempfile
from pathlib import Path
if os.stat('/dev/shm').st_dev == {device}:
    print(json.dumps('no /dev/shm of its own to spoil'))
    sys.exit()
from rclpy_virtual_time import ForkServer, HostDied, RosEnvironment
from rclpy_virtual_time.link.shared_memory import OURS
from rclpy_virtual_time.link.settings import EPOCH
from rclpy_virtual_time.tests.runs import PREAMBLE, end_of, run_beside_lidar
PORT = Path('/dev/shm', OURS[RosEnvironment.find().distro == 'kilted'] + 'port7411')
LEAVE = f'''
with open('{{PORT}}', 'wb') as file:
    file.write(bytes(44_208))
os.kill(os.getpid(), 9)
'''
ECHO = 'rclpy.init(); rclpy.spin(Echo())'
said = []
with tempfile.TemporaryDirectory() as folder, ForkServer(EPOCH) as forkserver:
    for source in (LEAVE, ECHO):
        (Path(folder) / 'echo.py').write_text(PREAMBLE + source)
        try:
            end = end_of(run_beside_lidar(forkserver, Path(folder), 'echo.py', seconds=1.0))
        except HostDied:
            end = 'died'
        said.append([end, PORT.exists()])
        PORT.write_bytes(bytes(44_208))  # as another program leaves it
print(json.dumps(said))
"""


def test_a_port_left_half_made_stops_no_other_node() -> None:
    """Fast DDS would wait for it for ever, be it a host's or another program's."""
    script = SHARED.format(device=SHM.stat().st_dev)
    (killed, left), (after, _) = said_by_ordinary(script, namespaces=False)
    assert (killed, left) == ("died", False)
    assert after == "completed"
