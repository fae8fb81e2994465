"""How old the judged file is, and whether its cell has changed since."""

import json
import os
from pathlib import Path

import pytest

from grader.errors import InputError
from grader.notebook import written
from grader.notebook.session import Session
from grader.notebook.written import age_of, newer_cell

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
def test_a_newer_cell_is_noticed(file: Path, cells: tuple[object, ...]) -> None:
    saved(file.parent, *cells)
    assert newer_cell(file).startswith("The cell “%%node agent.py” has changed")


def test_nothing_is_said_where_nothing_is_newer(file: Path) -> None:
    notebook = saved(file.parent, "%%node agent.py\nx = 1", "%%node other.py\ny = 1")
    assert newer_cell(file) == ""
    saved(file.parent, "%%node agent.py\nx = 2", kind="markdown")
    assert newer_cell(file) == ""
    saved(file.parent, "%%node agent.py\nx = 2")
    os.utime(notebook, (5e8, 5e8))  # older than the file, which was written from a terminal
    assert newer_cell(file) == ""


@pytest.mark.parametrize("content", ["{", "[]", '{"cells": [1]}', '{"cells": 3}', "[" * 99999])
def test_a_broken_notebook_is_no_error(file: Path, content: str) -> None:
    saved(file.parent).write_text(content)
    os.utime(file.with_name("lesson.ipynb"), (2e9, 2e9))
    assert newer_cell(file) == ""


def test_where_nobody_knows_the_notebook_nothing_is_said(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    saved(file.parent, "%%node agent.py\nx = 2")
    monkeypatch.delenv("JPY_SESSION_NAME")
    assert written._notebook() is None
    assert newer_cell(file) == ""


def test_a_module_whose_cell_was_not_saved_is_missed_where_it_is_used(tmp_path: Path) -> None:
    session = Session(refused={"helper.py": "'(' was never closed"})
    node, other = tmp_path / "node.py", tmp_path / "other.py"
    node.write_text("import helper\n")
    other.write_text("import math\n")
    with pytest.raises(InputError, match=r"the last %%node helper\.py cell was not saved"):
        session.usable(node, ["node.py"])
    assert session.usable(other, ["other.py"]) == other.resolve()
