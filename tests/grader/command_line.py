"""The command `course`, as people run it: its exit code, what it prints where."""

import contextlib
import io
import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from grader.cli import run

ROOT = Path(__file__).resolve().parent.parent.parent
SHORT = ("--scenario", "demo_wall", "--duration", "0.5")


@dataclass(frozen=True)
class Done:
    code: int
    out: str
    err: str

    @property
    def json(self) -> dict:  # type: ignore[type-arg]
        return json.loads(self.out)


def course(*arguments: object, **environment: str) -> Done:
    """Run it in this process, which has imported it already."""
    out, err = (io.TextIOWrapper(io.BytesIO(), encoding="utf-8") for _ in range(2))
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        for name, value in {"COLUMNS": "120", **environment}.items():
            patch.setenv(name, value)
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = run([str(argument) for argument in arguments])
    said = []
    for stream in (out, err):
        stream.flush()
        said.append(stream.buffer.getvalue().decode())  # type: ignore[attr-defined]
    return Done(code, *said)


def course_alone(*arguments: object, **environment: str) -> Done:
    """Run it in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-m", "grader.cli", *map(os.fsencode, map(str, arguments))],
        capture_output=True,
        check=False,
        cwd=ROOT,
        env={**os.environ, "COLUMNS": "120", **environment},
        timeout=120,
    )
    return Done(done.returncode, done.stdout.decode(), done.stderr.decode())
