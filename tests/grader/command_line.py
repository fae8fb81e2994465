"""The command `course`, as people run it: a process, its exit code, what it prints where."""

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

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
    done = subprocess.run(
        [sys.executable, "-m", "grader.cli", *map(os.fsencode, map(str, arguments))],
        capture_output=True,
        check=False,
        cwd=ROOT,
        env={**os.environ, "COLUMNS": "120", **environment},
        timeout=120,
    )
    return Done(done.returncode, done.stdout.decode(), done.stderr.decode())
