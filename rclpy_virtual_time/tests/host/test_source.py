"""What Python accepts as a file is accepted here, and nothing else."""

import subprocess
import sys
from pathlib import Path

import pytest

from rclpy_virtual_time.host.source import LOOKS_ON, compiled

BOM = b"\xef\xbb\xbf"
REFUSALS = (
    b"SyntaxError", b"IndentationError", b"TabError", b"ValueError", b"UnicodeDecodeError",
)  # fmt: skip
FILES = {
    "no declaration, a comment": b"# Zo\xeb\nx = 1\n",
    "no declaration, a string": b"x = 'Zo\xeb'\n",
    "no declaration, the last line": b"x = 1\n" * 3000 + b"# \xeb",
    "no declaration, carriage returns": b"x = 1\r# \xeb\rx = 2\r",
    "a declaration below it": b"# \xeb\n# coding: latin-1\nx = 1\n",
    "a declaration after code": b"x = 1\n# coding: latin-1\nx = '\xeb'\n",
    "latin-1": b"# coding: latin-1\nx = '\xeb'\n",
    "cp1252": b"# coding: cp1252\nx = '\x80'\n",
    "UTF-8 that is none, in a string": b"# coding: utf-8\nx = '\xeb'\n",
    "ASCII that is none": b"# coding: ascii\n# \xeb\nx = 1\n",
    "an unknown encoding": b"# coding: nonsense\nx = 1\n",
    "UTF-16": "x = 1\n".encode("utf-16"),
    "byte order mark": BOM + b"x = 'Zo\xc3\xab'\n",
    "byte order mark and UTF-8": BOM + b"# coding: utf-8\nx = 1\n",
    "byte order mark and latin-1": BOM + b"# coding: latin-1\nx = 1\n",
    "a cut character": b"x = 1\n# \xe2\x82",
    "a surrogate": b"# \xed\xa0\x80\nx = 1\n",
    "a null byte": b"x = 1\n# \0\n",
    "nothing": b"",
}


def python_accepts(file: Path) -> bool:
    """Return whether Python begins to run the file; what the file does then is another matter."""
    command = [sys.executable, "-I", "-S", "-X", "utf8", file]
    done = subprocess.run(command, capture_output=True, check=False)
    said = done.stderr.strip().splitlines()
    return not said or not said[-1].startswith(REFUSALS)


def accepts(file: Path) -> bool:
    try:
        compiled(str(file))
    except (SyntaxError, ValueError):
        return False
    return True


@pytest.mark.parametrize("name", FILES)
def test_the_same_files_as_python(name: str, tmp_path: Path) -> None:
    file = tmp_path / "agent.py"
    file.write_bytes(FILES[name])
    assert accepts(file) == python_accepts(file)


@pytest.mark.parametrize("above", [1, 2])
def test_the_message_is_pythons(tmp_path: Path, above: int) -> None:
    file = tmp_path / "agent.py"
    file.write_bytes(b"x = 1\n" * above + b"# Zo\xeb\n")
    with pytest.raises(SyntaxError) as caught:
        compiled(str(file))
    done = subprocess.run([sys.executable, file], capture_output=True, text=True, check=False)
    said = str(caught.value)
    if LOOKS_ON and above == 1:  # Python reads two lines before it looks: "on line 1"
        said = said.replace("line 2", "line 1")
    assert said in done.stderr


def test_annotations_are_evaluated_as_on_the_robot(tmp_path: Path) -> None:
    file = tmp_path / "agent.py"
    source = "def callback(scan: LaserScan) -> None: ...\n"
    file.write_text(source)
    if sys.version_info >= (3, 14):  # PEP 649: only when asked for
        exec(compiled(str(file)), {})
        file.write_text(f"{source}callback.__annotations__\n")
    with pytest.raises(NameError, match="LaserScan"):
        exec(compiled(str(file)), {})
    file.write_text("from __future__ import annotations\ndef callback(scan: LaserScan): ...\n")
    exec(compiled(str(file)), {})
