"""How old a judged file is, and whether it is what the notebook's cell writes."""

import os
import time
from pathlib import Path

from grader.course.submission import MAX_SIZE, read_regular_file
from grader.nbgrader.cells import last_definitions
from grader.nbgrader.intake import cells_in
from grader.notebook.cells import MAGIC
from grader.notebook.show import shell
from rclpy_virtual_time import FileReader, open_regular_file

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


def other_cell(path: Path) -> str:
    """Warn if the saved notebook has another text for a file, or none; "" if it has this one.

    A cell that wrote it in this kernel may not be saved yet. Where nobody says which notebook this
    is, as on Colab, nothing is known.
    """
    notebook = _notebook()
    if notebook is None:
        return ""
    try:
        newer = notebook.stat().st_mtime > path.stat().st_mtime
        own = read_regular_file(path, MAX_SIZE).decode("utf-8")
        with open_regular_file(notebook) as file:  # the student's own, in the student's process
            cells = [(cell.kind, cell.source) for cell in cells_in(file)]
    except (OSError, UnicodeDecodeError, FileReader.Refused):
        return ""
    texts, _ = last_definitions(cells, [path.name])
    if texts.get(path.name) == own:
        return ""
    if path.name in texts and newer:
        return (
            f"The cell “{MAGIC} {path.name}” has changed since it was run: this is about the "
            "file as it was. Run the cell, then check again."
        )
    history = getattr(getattr(shell(), "history_manager", None), "input_hist_raw", ())
    ran, _ = last_definitions([("code", source) for source in history], [path.name])
    if not newer and ran.get(path.name) == own:
        return ""
    return (
        f"No cell of this notebook, as it is saved, writes this {path.name}: hand in the file, or "
        f"put its text into a cell “{MAGIC} {path.name}”, run it, and save."
    )


def _notebook() -> Path | None:
    """Return this kernel's notebook, where Jupyter or VS Code says which it is."""
    said = os.environ.get("JPY_SESSION_NAME", "")
    if not said and (running := shell()) is not None:
        said = str(running.user_ns.get("__vsc_ipynb_file__", ""))
    path = Path(said)
    return path if path.suffix == ".ipynb" and path.is_file() else None
