"""What all tests share: warm fork servers, things that are made once, how many workers run them."""

from __future__ import annotations

import fcntl
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from grader.course.exercises import ROOT
from grader.link.hosts import ForkServer
from grader.link.pool import ForkServerPool

MadeOnce = Callable[[str, Callable[[Path], object]], Path]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int | None:
    """Run three workers on two CPUs: one of them waits for a robot, a process or a browser."""
    if "PYTEST_XDIST_AUTO_NUM_WORKERS" in os.environ:
        return None  # pytest-xdist reads it
    cpus = len(os.sched_getaffinity(0))
    return cpus + cpus // 2


@pytest.fixture(scope="session")
def forkservers() -> Iterator[ForkServerPool]:
    """A warm fork server for each set of libraries that is asked for."""
    with ForkServerPool() as pool:
        yield pool


@pytest.fixture(scope="session")
def forkserver(forkservers: ForkServerPool) -> ForkServer:
    """A warm fork server without libraries."""
    return forkservers.of()


@pytest.fixture(scope="session")
def made_once(tmp_path_factory: pytest.TempPathFactory) -> MadeOnce:
    """Make a folder by its name, once in a session, whichever of pytest's workers comes first."""
    base = tmp_path_factory.getbasetemp()
    root = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base

    def folder_of(name: str, make: Callable[[Path], object]) -> Path:
        folder = root / name
        with (root / f"{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not (folder / "made").exists():
                shutil.rmtree(folder, ignore_errors=True)
                folder.mkdir()
                make(folder)
                (folder / "made").touch()
        return folder

    return folder_of


@pytest.fixture(scope="session")
def site(made_once: MadeOnce) -> Path:
    """The folder of the lesson's site. Its build has nothing to complain about."""
    for library in ("sphinx", "myst_parser", "furo"):
        pytest.importorskip(library, reason=f"{library} is not installed: pip install '.[site]'")
    return made_once("site", build_site) / "html"


def build_site(folder: Path) -> None:
    """Build the lesson; the build's last words stand beside it."""
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-n", "-q", "-b", "html"]
    command += ["-d", str(folder / "doctrees"), str(ROOT / "lessons"), str(folder / "html")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    (folder / "said.txt").write_text(done.stdout + done.stderr, "utf-8")
