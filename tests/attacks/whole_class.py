"""A class to grade: what students hand in, and the hostile kit in one file."""

import sys
from collections.abc import Mapping
from pathlib import Path

from arena import HERE

COURSE = [sys.executable, "-m", "grader.cli", "autograde"]


def kit() -> str:
    """Return what puts the hostile files' kit in front of them: here each is one file."""
    texts = {name: (HERE / f"{name}.py").read_text("utf-8") for name in ("kit", "seeing")}
    return (
        "import sys as _s, types as _t\n"
        f"for _n, _x in {texts!r}.items():\n"
        "    _m = _s.modules[_n] = _t.ModuleType(_n)\n"
        "    _m.__file__ = __file__\n"
        "    exec(_x, _m.__dict__)\n"
    )


def hand_in(folder: Path, student: str, files: Mapping[str, str | bytes]) -> None:
    """Put a student's files where a class hands in."""
    (folder / student).mkdir(parents=True)
    for name, content in files.items():
        data = content.encode() if isinstance(content, str) else content
        (folder / student / name).write_bytes(data)
