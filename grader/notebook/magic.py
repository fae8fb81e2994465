"""The cell magic `%%node FILE.py`: the cell becomes a file, if Python can parse it."""

from __future__ import annotations

import html
import os
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grader.course.submission import MAX_SIZE
from grader.errors import GraderError
from grader.nbgrader.cells import Definition
from grader.notebook import guard
from grader.notebook.cells import MAGIC, CellProblem, check_syntax, ended, file_name
from grader.notebook.session import SESSION, exercise_of
from grader.notebook.show import show, tell

if TYPE_CHECKING:
    from IPython.core.interactiveshell import InteractiveShell

OURS = (
    "grader",
    "rclpy_virtual_time",
    "sim",
    "rclpy",
    "numpy",
    "IPython",
    "ipykernel",
    "matplotlib",
    "sklearn",
)


def register(shell: InteractiveShell) -> None:
    """Register `%%node` with a shell."""
    magics: Any = shell
    magics.register_magic_function(node, magic_kind="cell", magic_name="node")
    guard.register(shell)


def node(line: str, cell: str) -> None:
    """Save the cell beside the notebook, in the file that the first line names.

    Example: `%%node my_agent.py`. If Python can't parse the cell, a message says
    where, and the file is left as it was.
    """
    words = line.strip()
    try:
        name = words = file_name(line)
        _refuse_to_hide(name)
        found = Definition(name, ended(cell))
        check_syntax(found)
        path = _write(found)
    except CellProblem as problem:
        _explain(words, problem)
        return
    except OSError as error:
        _explain(words, CellProblem(f"the file can't be written: {error.strerror}"))
        return
    SESSION.wrote(path)
    _confirm(found)
    _warm_up(path.name)


def _refuse_to_hide(name: str) -> None:
    stem = name.removesuffix(".py")
    if stem in sys.stdlib_module_names or stem in OURS:
        raise CellProblem(
            f"a file {name} would hide the module {stem} from this notebook and from your node: "
            f"choose another name, such as my_{name}"
        )


def _write(cell: Definition) -> Path:
    """Write the file atomically: nobody reads half of it."""
    data = cell.text.encode("utf-8")
    if len(data) > MAX_SIZE:
        raise CellProblem(f"the cell has {len(data):,} bytes; at most {MAX_SIZE:,} are read")
    path = Path.cwd() / cell.file
    if path.is_dir():
        raise CellProblem(f"{cell.file} is a folder here: choose another name")
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=".", suffix=".tmp")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        Path(temporary).chmod(0o644)
        Path(temporary).replace(path)
    except OSError:
        Path(temporary).unlink(missing_ok=True)
        raise
    return path


def _confirm(cell: Definition) -> None:
    lines = cell.text.count("\n")
    said = f"Saved {cell.file} ({lines} {'line' if lines == 1 else 'lines'})."
    show({"text/plain": said, "text/html": _with_source(said, cell)})


def _with_source(said: str, cell: Definition) -> str:
    """Return the confirmation as HTML, with the highlighted source folded away below."""
    import IPython.display  # noqa: PLC0415

    display: Any = IPython.display
    code = display.Code(data=cell.text, language="python")._repr_html_()
    return (
        f'<details><summary style="cursor:pointer">{html.escape(said)}</summary>'
        f'<div style="background:#f7f7f8;color:#17202a;padding:8px 12px;border-radius:6px;'
        f'overflow:auto;max-height:480px">{code}</div></details>'
    )


def _explain(name: str, problem: CellProblem) -> None:
    """Say what is wrong and where, and what became of the file."""
    why = problem.text if problem.line is None else f"line {problem.line}: {problem.text}"
    if name:
        SESSION.refused.pop(name, None)
        SESSION.refused[name] = why
    lines = [f"Not saved: {why}"]
    if problem.shown:
        # the magic's line counts in the cell, not in the file
        lines = [
            f"Not saved: {name}, line {problem.line} (line {(problem.line or 0) + 1} of the cell): "
            f"{problem.text}",
            *(f"    {line}" for line in problem.shown.split("\n")),
        ]
    kept = name and Path(name).name == name and Path(name).is_file()
    lines.append(
        f"Correct the cell and run it again. {name} on disk is unchanged."
        if kept
        else f"Correct the cell and run it again: its first line is “{MAGIC} FILE.py”."
        if not problem.shown
        else "Correct the cell and run it again."
    )
    tell("\n".join(lines))


def _warm_up(name: str) -> None:
    """Let the judge start while the student reads on."""
    from grader.notebook.child import JUDGE  # noqa: PLC0415

    try:
        exercise = exercise_of(name)
        JUDGE.warm(() if exercise is None else exercise.libraries)
    except (GraderError, OSError):
        return  # `drive` and `check` will say it
