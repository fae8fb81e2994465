"""The place where attacks are tried: things to steal, to spoil and to reach, and their keepers.

All of them belong to the test. The worst case is played: a submission is told every path, process
and port that there is to attack (`targets.json`), and only has to get there.
"""

from __future__ import annotations

import ast
import contextlib
import json
import os
import resource
import secrets
import select
import shutil
import signal
import socket
import stat
import subprocess
import sys
import tempfile
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

from grader.course.exercises import find_exercise
from grader.course.submission import Submission
from grader.grading.grading import Grading, grade, grade_submission
from grader.recording import Recording
from grader.trial.trials import NodeTrials
from grader.trial.virtual_time import Limits
from rclpy_virtual_time.host.sandbox.layers import CALLS, USER
from rclpy_virtual_time.host.sandbox.users import USERS
from rclpy_virtual_time.link.hosts import ForkServer
from sim.scenario import Scenario

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
HONEST = tuple(sorted((HERE / "honest").glob("*.*")))  # .bom, .latin1: tools change them
EXERCISE = find_exercise("obstacle_avoidance")
REFERENCE = Submission(EXERCISE.solutions / EXERCISE.files[0])
FULL = os.environ.get("COURSE_ATTACKS") == "full"
SOME = ("wiring", "clear_zone", "stop_zone", "ignores_behind")  # one short scenario
HASTY = Limits(start=5.0, step=2.0, total=20.0)  # [s] for those that hang
PLACES = ("/tmp", "/var/tmp", "/dev/shm", "/dev", "/", "/root", str(ROOT), str(Path.cwd()))
LISTENER = """
import signal, sys, time
signal.signal(signal.SIGUSR2, lambda *_: open(sys.argv[1], "a").write("hit"))
print("ready", flush=True)
while True:
    time.sleep(3600)
"""


@dataclass(frozen=True)
class Trick:
    """A function of a hostile file; its mark says what may become of it."""

    path: Path  # of the file, which is named after the family
    function: str
    outcomes: frozenset[str] = frozenset({"completed"})  # of its trials; "any" stands for all
    score: int = 20  # at most
    full: bool = False  # only worth trying with all checks

    @property
    def name(self) -> str:
        """Return the family and the function."""
        return f"{self.path.stem}_{self.function}"

    @property
    def hangs(self) -> bool:
        """Return whether its trials end by the clock."""
        return "hung" in self.outcomes

    @property
    def text(self) -> str:
        """Return the submission: the whole family, and a last line that plays this trick."""
        last = f"from kit import run  # noqa: E402\n\nrun({self.function})\n"
        return f"{self.path.read_text('utf-8')}\n\n{last}"


def tricks_of(path: Path) -> Iterator[Trick]:
    """Read the marks of a hostile file, which would run in a host only."""
    for node in ast.parse(path.read_text("utf-8")).body:
        for mark in getattr(node, "decorator_list", ()):
            if ast.unparse(mark).startswith("trick("):
                named = {each.arg: ast.literal_eval(each.value) for each in mark.keywords}
                outcomes = frozenset(map(ast.literal_eval, mark.args)) or Trick.outcomes
                yield Trick(path, node.name, outcomes, **named)


HOSTILE = tuple(
    trick for path in sorted((HERE / "hostile").glob("*.py")) for trick in tricks_of(path)
)


class Hasty(NodeTrials):
    """Trials without a second look, in real time, at what hung."""

    def _look_again(self, scenario: Scenario, virtual: Recording) -> Recording:
        return virtual


class Arena:
    """What there is to gain, and what became of it.

    Parameters
    ----------
    layers
        Those that the hosts have: what could harm this machine is only tried behind them.
    """

    def __init__(self, layers: Collection[str]) -> None:
        base = Path("/var/tmp") if os.access("/var/tmp", os.W_OK) else Path(tempfile.gettempdir())
        self.folder = Path(tempfile.mkdtemp(prefix="arena-", dir=base))
        self.folder.chmod(0o755)
        self.word = secrets.token_hex(12)
        self.mark = f"course-mark-{secrets.token_hex(6)}"
        self.beside = self.folder / "beside"
        self.played = self.folder / "played"
        self._keepers: list[socket.socket] = []
        self._processes: list[subprocess.Popen[str]] = []
        self._make_files()
        self._make_sockets()
        self._make_processes()
        self._harmless = not {USER, CALLS} <= set(layers)
        self._tell()
        self._before = self._state()

    def __enter__(self) -> Arena:
        return self

    def __exit__(self, *_: object) -> None:
        self._dismiss()
        self._sweep()
        shutil.rmtree(self.folder, ignore_errors=True)

    def submission(self, path: Path) -> Submission:
        """Return a submission with the kit and the targets beside it."""
        if path.suffix != ".py":
            path = Path(shutil.copyfile(path, self.beside / f"{path.stem}.py"))
        return Submission(path, "", tuple(self.beside.iterdir()))

    def tricked(self, trick: Trick) -> Path:
        """Write the submission that plays a trick."""
        path = self.played / f"{trick.name}.py"
        path.write_text(trick.text, "utf-8")
        return path

    def grade(
        self, path: Path, forkserver: ForkServer, *, hasty: bool, everything: bool
    ) -> Grading:
        """Grade a submission with all checks, or with some."""
        submission, only = self.submission(path), () if everything else SOME
        if not hasty:
            return grade_submission(EXERCISE, submission, forkserver, file=path.name, only=only)
        with Hasty(submission, forkserver, limits=HASTY) as trials:
            return grade(EXERCISE, trials, file=path.name, only=only)

    def said(self, recordings: Collection[Recording]) -> list[str]:
        """Return what the submission boasts of, and which secrets its output holds."""
        lines = [line.text for recording in recordings for line in recording.log]
        found = {line.removeprefix("GAINED ") for line in lines if line.startswith("GAINED ")}
        if any(self.word in line for line in lines):
            found.add("prints what is secret")
        for line in lines:
            if line.startswith("LEFT ") and _end(int(line.removeprefix("LEFT "))):
                found.add("leaves processes behind")
        return sorted(found)

    def losses(self) -> list[str]:
        """Return what has changed, what was reached and what stayed behind; put it right again."""
        found = []
        before, now = self._before, self._state()
        found += [f"changes files of others: {key}" for key in before.keys() | now.keys()
                  if before.get(key) != now.get(key)]  # fmt: skip
        readable, _, _ = select.select(self._keepers, [], [], 0)
        found += [f"talks to this machine: {self._name(keeper)}" for keeper in readable]
        if self._processes[0].poll() is not None:
            found.append("signals other processes: SIGKILL came")
        if (self.folder / "hit").exists():
            found.append("signals other processes: through a pipe")
        found += [f"leaves files behind: in {path.parent}" for path in self._sweep()]
        if found:
            self._repair()
        return sorted(found)

    def _make_files(self) -> None:
        self.files = []
        for name, text in (
            ("solutions/reference_solution.py", f"ANSWER = '{self.word}'\n"),
            ("secret/secret.txt", f"{self.word}\n"),
            ("secret/closed.txt", f"{self.word}\n"),
            ("neighbour/submission.py", f"# by another student: {self.word}\n"),
        ):
            path = self.folder / name
            path.parent.mkdir(exist_ok=True)
            path.parent.chmod(0o755)
            path.write_text(text)
            path.chmod(0o600 if path.stem == "closed" else 0o644)
            self.files.append(str(path))
        for name in ("watched", "beside", "played"):
            (self.folder / name).mkdir(exist_ok=True)
        (self.folder / "watched").chmod(0o777)
        for name in ("kit.py", "seeing.py"):
            shutil.copyfile(HERE / name, self.beside / name)

    def _make_sockets(self) -> None:
        tcp = socket.create_server(("127.0.0.1", 0))
        udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        udp.bind(("127.0.0.1", 0))
        unix = socket.socket(socket.AF_UNIX)
        unix.bind(str(self.folder / "socket"))
        (self.folder / "socket").chmod(0o777)
        unix.listen()
        abstract = socket.socket(socket.AF_UNIX)
        abstract.bind(f"\0{self.mark}")
        abstract.listen()
        self._keepers = [tcp, udp, unix, abstract]

    def _make_processes(self) -> None:
        quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "text": True}
        bystander = subprocess.Popen(["sleep", "3600"], **quiet)
        command = [sys.executable, "-c", LISTENER, str(self.folder / "hit")]
        listener = subprocess.Popen(command, **quiet)
        assert listener.stdout is not None
        listener.stdout.readline()
        self._processes = [bystander, listener]

    def _tell(self) -> None:
        bystander, listener = self._processes
        folders = ("solutions", "secret", "neighbour", "watched")
        targets = {
            "files": self.files,
            "folders": [str(self.folder / name) for name in folders],
            "watched": str(self.folder / "watched"),
            "repository": str(ROOT),
            "mark": self.mark,
            "word": self.word[:-4],  # so that the file itself is no loot
            "judge": os.getpid(),
            "bystander": bystander.pid,
            "listener": listener.pid,
            "tcp": self._keepers[0].getsockname()[1],
            "udp": self._keepers[1].getsockname()[1],
            "unix": str(self.folder / "socket"),
            "abstract": self.mark,
            "all": not self._harmless,
        }
        (self.beside / "targets.json").write_text(json.dumps(targets))

    def _state(self) -> dict[str, object]:
        """Return what must not change: files, places for files, and the judge's own means."""
        found: dict[str, object] = {
            "limits of the judge": [resource.getrlimit(limit) for limit in range(16)],
            "priority of the judge": os.getpriority(os.PRIO_PROCESS, 0),
        }
        for path in self.folder.rglob("*"):
            if path.name == "hit" or {self.beside, self.played} & {path, path.parent}:
                continue
            status = path.lstat()
            text = path.read_bytes() if stat.S_ISREG(status.st_mode) else b""
            owner = (status.st_uid, status.st_gid, oct(status.st_mode))
            found[str(path.relative_to(self.folder))] = (owner, status.st_mtime_ns, text)
        return found

    def _dismiss(self) -> None:
        for keeper in self._keepers:
            keeper.close()
        for process in self._processes:
            process.kill()
            process.communicate()

    def _repair(self) -> None:
        self._dismiss()
        resource.setrlimit(resource.RLIMIT_CORE, resource.getrlimit(resource.RLIMIT_CORE))
        for path in self.folder.iterdir():
            if path not in (self.beside, self.played):
                shutil.rmtree(path) if path.is_dir() else path.unlink()
        self._make_files()
        self._make_sockets()
        self._make_processes()
        self._tell()
        self._before = self._state()

    def _sweep(self) -> list[Path]:
        """Remove what bears this arena's mark; return it."""
        found = []
        for place in dict.fromkeys(PLACES):
            with contextlib.suppress(OSError):
                found += list(Path(place).glob(f"{self.mark}*"))
        for path in found:
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            else:
                path.unlink(missing_ok=True)
        return found

    def _name(self, keeper: socket.socket) -> str:
        return ("TCP", "UDP", "a Unix socket", "an abstract socket")[self._keepers.index(keeper)]


def _end(pid: int) -> bool:
    """End a process that a submission has left behind; tell whether it was still there."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        os.kill(pid, signal.SIGKILL)
    except OSError:
        return False
    return state != "Z"


def orphans() -> set[int]:
    """Return the processes of hosts' users that have lost their fork server."""
    found = set()
    for folder in Path("/proc").iterdir():
        with contextlib.suppress(OSError, ValueError):
            fields = (folder / "stat").read_text().rpartition(")")[2].split()
            if folder.stat().st_uid in USERS and fields[1] == "1" and fields[0] != "Z":
                found.add(int(folder.name))
    return found


def children(pid: int) -> list[str]:
    """Return the processes that a process has started and not yet buried."""
    return Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
