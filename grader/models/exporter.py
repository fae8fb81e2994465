"""Get model files, kept or from another process: the judge imports no machine-learning library."""

from __future__ import annotations

import atexit
import base64
import contextlib
import functools
import hashlib
import importlib.metadata
import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from grader.errors import GraderError
from rclpy_virtual_time import PracticeServer

ROOT = Path(__file__).resolve().parents[2]
ROOMS = (ROOT / "sim", ROOT / "grader" / "models")  # whose code is in a file
LIBRARIES = ("numpy", "scipy", "scikit-learn", "onnx", "torch", "keras")
COMMAND = (sys.executable, "-s", "-X", "utf8", "-m", "grader.models.formats")


class Exporter:
    """The process (see grader.models.formats), started on demand, and a cache of its files."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._made: dict[str, bytes] = {}
        self._process: subprocess.Popen[str] | None = None

    def content(self, suffix: str, probe: str, settings: Mapping[str, Any]) -> bytes:
        """Return the content of a model file.

        Raises GraderError: a library is missing, or there is no such model in this format.
        """
        request = json.dumps({"suffix": suffix, "probe": probe, "settings": dict(settings)})
        with self._lock:
            if request not in self._made:
                self._made[request] = _kept(request, self._ask)
            return self._made[request]

    def close(self) -> None:
        """End the process; a later request starts a new one."""
        with self._lock:
            if self._process is not None:
                self._process.terminate()  # it may be importing for seconds
                self._process.communicate()
                self._process = None

    def _ask(self, request: str) -> bytes:
        process = self._started()
        assert process.stdin is not None and process.stdout is not None
        try:
            process.stdin.write(request + "\n")
            process.stdin.flush()
            answer = json.loads(process.stdout.readline())
        except (OSError, ValueError) as error:
            raise GraderError(f"no model file {request}: the exporter has ended") from error
        if "problem" in answer:
            raise GraderError(f"no model file {request}: {answer['problem']}")
        return base64.b64decode(answer["content"])

    def _started(self) -> subprocess.Popen[str]:
        if self._process is None:
            environment = {**os.environ, **PracticeServer.SAME_RUNS}
            environment.pop("PYTHONSAFEPATH", None)  # ROOT is on its path
            self._process = subprocess.Popen(
                COMMAND,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                text=True,
                cwd=ROOT,
                env=environment,
            )
        return self._process


def _kept(request: str, make: Callable[[str], bytes]) -> bytes:
    """Return the file for a request; one that is made anew is kept, if there are room and home."""
    with contextlib.suppress(OSError):
        return _place(request).read_bytes()
    content = make(request)
    with contextlib.suppress(OSError):
        place = _place(request)
        place.parent.mkdir(parents=True, exist_ok=True)
        written = place.with_suffix(f".{os.getpid()}")
        written.write_bytes(content)
        written.replace(place)
    return content


def _place(request: str) -> Path:
    """Return where a file is kept, in the XDG cache folder.

    Raises OSError: this user has no home.
    """
    name = hashlib.sha256(f"{_origin()} {request}".encode()).hexdigest()
    try:
        home = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser()
    except RuntimeError as error:
        raise OSError(str(error)) from None
    return home / "rclpy-agents-course" / name


@functools.cache
def _origin() -> str:
    """Return a hash of what makes a file what it is, besides the request: code and libraries."""
    found = hashlib.sha256(sys.version.encode())
    for name in LIBRARIES:
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            found.update(f"{name} {importlib.metadata.version(name)}\n".encode())
    for file in sorted(each for room in ROOMS for each in room.iterdir() if each.is_file()):
        found.update(file.read_bytes())
    return found.hexdigest()


EXPORTER = Exporter()
atexit.register(EXPORTER.close)
