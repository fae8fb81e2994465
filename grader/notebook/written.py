"""How old a judged file is, and whether the notebook's cell has changed since."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from typing import Any

from grader.course.submission import MAX_SIZE, read_regular_file
from grader.notebook.cells import MAGIC, QUOTES, ended

MAX_NOTEBOOK = 32 * 1024 * 1024  # [bytes]
MINUTE, HOUR, DAY = 60, 3600, 86_400  # [s]


def age_of(path: Path, now: float | None = None) -> str:
    """Return when a file was written, as "12 s ago"."""
    at = path.stat().st_mtime
    seconds = max(0.0, (time.time() if now is None else now) - at)
    if seconds < 2 * MINUTE:
        return f"{seconds:.0f} s ago"
    if seconds < 2 * HOUR:
        return f"{seconds // MINUTE:.0f} min ago"
    if seconds < DAY:
        return f"{seconds // HOUR:.0f} h ago"
    return time.strftime("on %d %b %Y at %H:%M", time.localtime(at))


def newer_cell(path: Path) -> str:
    """Warn if the saved notebook has another text for a file than the file has; "" if not.

    Where nobody says which notebook this is, as on Colab, nothing is known.
    """
    notebook = _notebook()
    if notebook is None:
        return ""
    try:
        if notebook.stat().st_mtime <= path.stat().st_mtime:
            return ""
        saved = _saved(json.loads(read_regular_file(notebook, MAX_NOTEBOOK)), path.name)
        own = read_regular_file(path, MAX_SIZE).decode("utf-8")
    except (OSError, ValueError, RecursionError, TypeError, AttributeError, KeyError):
        return ""
    if saved is None or saved == own:
        return ""
    return (
        f"The cell “{MAGIC} {path.name}” has changed since it was run: this is about the file as "
        "it was. Run the cell, then check again."
    )


def _notebook() -> Path | None:
    """Return this kernel's notebook, where Jupyter or VS Code tells it."""
    told = os.environ.get("JPY_SESSION_NAME", "")
    if not told:
        from IPython.core.getipython import get_ipython  # noqa: PLC0415

        shell: Any = get_ipython()
        told = str(shell.user_ns.get("__vsc_ipynb_file__", "")) if shell is not None else ""
    path = Path(told)
    return path if path.suffix == ".ipynb" and path.is_file() else None


def _saved(notebook: Any, name: str) -> str | None:
    """Return the text of the last cell for a file; None if there is none."""
    found = None
    for cell in notebook["cells"]:
        source = cell.get("source", "")
        source = source if isinstance(source, str) else "".join(source)
        first, _, rest = source.partition("\n")
        magic, _, words = first.strip().partition(" ")
        if cell.get("cell_type") == "code" and magic == MAGIC and words.strip(f" {QUOTES}") == name:
            found = ended(rest)
    return found
