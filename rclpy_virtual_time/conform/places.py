"""Two places to run a program in: plain Python, in real time, and a host, in virtual time."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from rclpy_virtual_time.host.frames import Ended, ProgramStart, Run, Settled, Start
from rclpy_virtual_time.host.sandbox.users import never_gain_capabilities
from rclpy_virtual_time.link.exchange import HostDied, HostForged, HostHung
from rclpy_virtual_time.link.hosts import ForkServer
from rclpy_virtual_time.link.link import Link
from rclpy_virtual_time.link.settings import EPOCH

SECOND = 1_000_000_000  # [ns]
SILENCE = 60.0  # [s] without progress after which a plain run is ended
STEP_LIMIT = 20.0  # [s] of wall time for one virtual second
DOMAIN = 77  # of DDS: plain runs hear nobody else on this machine

Progress = Callable[[], int]  # goes up while a run gets on


@dataclass(frozen=True)
class Ran:
    """How a run ended."""

    kind: str  # as in `Ended`, or "hung", "died", "stuck", "time"
    text: str
    said: str = ""  # on stdout and stderr


def run_inside(
    forkserver: ForkServer,
    folder: Path,
    program: ProgramStart,
    seconds: float,
    progress: Progress = lambda: 0,
) -> Ran:
    """Run a program in a host, without a robot, until `seconds` [s] have gone by since progress."""
    with forkserver.workplace(folder, limited=False) as place, forkserver.host(place) as link:
        try:
            kind, text = _conduct(link, program, round(seconds), progress)
        except HostHung as hung:
            kind, text = "hung", hung.stacks
        except HostDied:
            kind, text = "died", link.wait(1.0)
        except HostForged as forged:
            kind, text = "forged", str(forged)
        return Ran(kind, text, "\n".join(line.text for line in link.log()))


def _conduct(
    link: Link, program: ProgramStart, seconds: int, progress: Progress
) -> tuple[str, str]:
    start = Start((program,), EPOCH, seed=1, offers=(), lead=1)
    answer: object = link.run(start, STEP_LIMIT)[0]
    now, left, seen = 0, seconds, progress()
    while isinstance(answer, Settled):
        if progress() > seen:
            left, seen = seconds, progress()
        if left == 0:
            return "time", f"{seconds} s have gone by"
        if now and not answer.spinning and not answer.asleep:
            return "stuck", "nothing in it can ever run again"
        now, left = now + 1, left - 1
        answer = link.run(Run(now * SECOND), STEP_LIMIT)[0]
    assert isinstance(answer, Ended), answer
    return answer.kind, f"{answer.text}\n{answer.detail}"


def run_plain(
    forkserver: ForkServer, folder: Path, command: Sequence[str], progress: Progress = lambda: 0
) -> Ran:
    """Run a program as a process until it ends, or until SILENCE without progress."""
    environment = {
        **forkserver.environment,
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_DOMAIN_ID": str(DOMAIN),
        "ROS_LOG_DIR": str(folder),
        "HOME": str(folder),
        "PYTHONPATH": os.pathsep.join(map(str, forkserver.ros.python_path)),
    }
    with (folder / "plain.log").open("w+") as log:
        process = subprocess.Popen(
            [sys.executable, "-s", "-B", "-X", "utf8", *command],
            cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
            start_new_session=True,
            # CPython's tests of time would set the machine's clock. No thread has been started.
            preexec_fn=never_gain_capabilities,  # noqa: PLW1509
        )  # fmt: skip
        try:
            kind, text = _await(process, progress)
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        log.seek(0)
        return Ran(kind, text, log.read())


def _await(process: subprocess.Popen[bytes], progress: Progress) -> tuple[str, str]:
    seen, end = progress(), time.monotonic() + SILENCE
    while time.monotonic() < end:
        status = process.poll()
        if status is not None:
            kind = "returned" if status == 0 else "exited" if status > 0 else "died"
            return kind, str(status)
        if progress() > seen:
            seen, end = progress(), time.monotonic() + SILENCE
        time.sleep(0.05)
    return "time", f"{SILENCE} s have gone by"
