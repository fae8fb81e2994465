"""Get model files from another process: the judge imports no machine-learning library."""

from __future__ import annotations

import atexit
import base64
import json
import os
import subprocess
import sys
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grader.errors import GraderError
from rclpy_virtual_time import PracticeServer

ROOT = Path(__file__).resolve().parents[2]
COMMAND = (sys.executable, "-s", "-B", "-X", "utf8", "-m", "grader.models.formats")


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
                self._made[request] = self._ask(request)
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


EXPORTER = Exporter()
atexit.register(EXPORTER.close)
