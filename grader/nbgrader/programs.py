"""Let nbgrader find the programs that it runs by name."""

import os
import sys
from pathlib import Path


def find_programs() -> None:
    """Let nbgrader find `alembic` in an environment that is not activated."""
    programs = str(Path(sys.executable).parent)
    paths = os.environ.get("PATH", os.defpath).split(os.pathsep)
    if programs not in paths:
        os.environ["PATH"] = os.pathsep.join([programs, *paths])
