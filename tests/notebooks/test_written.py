"""How old the judged file is, and whether its cell has changed since."""

import json
import os
from pathlib import Path
from types import SimpleNamespace

import pytest

from grader.errors import InputError
from grader.notebook import written
from grader.notebook.session import Session
from grader.notebook.written import age_of, other_cell

FILE = "agent.py"


def saved(folder: Path, *cells: object, kind: str = "code") -> Path:
    """A notebook beside the file, written after it."""
    path = folder / "lesson.ipynb"
    path.write_text(json.dumps({"cells": [{"cell_type": kind, "source": c} for c in cells]}))
    os.utime(path, (2e9, 2e9))
    return path


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / FILE
    path.write_text("x = 1\n")
    os.utime(path, (1e9, 1e9))
    monkeypatch.setenv("JPY_SESSION_NAME", str(tmp_path / "lesson.ipynb"))
    return path


@pytest.mark.parametrize(
    ("seconds", "said"),
    [(-5, "0 s ago"), (12, "12 s ago"), (200, "3 min ago"), (7300, "2 h ago"), (9e5, "on 0")],
)
def test_the_age_in_words(file: Path, seconds: float, said: str) -> None:
    assert age_of(file, 1e9 + seconds).startswith(said)


@pytest.mark.parametrize(
    "cells",
    [
        ("%%node agent.py\nx = 2",),
        (["%%node agent.py\n", "x = 2"],),
        ("%%node agent.py\nx = 1", "%%node 'agent.py'\nx = 3"),
    ],
)
def test_a_other_cell_is_noticed(file: Path, cells: tuple[object, ...]) -> None:
    saved(file.parent, *cells)
    assert other_cell(file).startswith("The cell “%%node agent.py” has changed")


@pytest.mark.parametrize("magic", ["%%node", "%%writefile", "%%file"])
def test_a_file_that_no_cell_of_the_notebook_writes(
    file: Path, magic: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = "No cell of this notebook, as it is saved, writes this agent.py"
    ran = SimpleNamespace(input_hist_raw=["1/0", f"{magic} agent.py\nx = 1"])
    notebook = saved(file.parent, f"{magic} agent.py\nx = 1", "%%node other.py\ny = 1")
    assert other_cell(file) == ""
    saved(file.parent, "%%node other.py\nx = 1")
    assert other_cell(file).startswith(said)
    saved(file.parent, f"{magic} agent.py\nx = 2")
    os.utime(notebook, (5e8, 5e8))  # older than the file, which an editor or a terminal wrote
    assert other_cell(file).startswith(said)
    monkeypatch.setattr(written, "shell", lambda: SimpleNamespace(history_manager=ran))
    assert other_cell(file) == ""  # or this kernel, with a cell that is not saved yet
    file.write_text("x = 3\n")
    assert other_cell(file).startswith(said)


@pytest.mark.parametrize("content", ["{", "[]", '{"cells": [1]}', '{"cells": 3}', "[" * 99999])
def test_a_broken_notebook_is_no_error(file: Path, content: str) -> None:
    saved(file.parent).write_text(content)
    os.utime(file.with_name("lesson.ipynb"), (2e9, 2e9))
    assert other_cell(file) == ""


def test_where_nobody_knows_the_notebook_nothing_is_said(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    saved(file.parent, "%%node agent.py\nx = 2")
    monkeypatch.delenv("JPY_SESSION_NAME")
    assert written._notebook() is None
    assert other_cell(file) == ""


def test_a_module_whose_cell_was_not_saved_is_missed_where_it_is_used(tmp_path: Path) -> None:
    session = Session(refused={"helper.py": "'(' was never closed"})
    node, other = tmp_path / "node.py", tmp_path / "other.py"
    node.write_text("import helper\n")
    other.write_text("import math\n")
    with pytest.raises(InputError, match=r"the last %%node helper\.py cell was not saved"):
        session.usable(node, ["node.py"])
    assert session.usable(other, ["other.py"]) == other.resolve()
