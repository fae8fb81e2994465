"""Whatever a student hands in: the notebook that is graded has nbgrader's cells as released."""

import json
import os
from pathlib import Path
from typing import Any

import nbformat
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grader.course.submission import MAX_SIZE
from grader.nbgrader import intake
from grader.nbgrader.cells import definition
from grader.nbgrader.intake import Cell, read_cells
from grader.nbgrader.restore import ABOUT, Trusted, restored, unreadable
from rclpy_virtual_time import FileReader

NODE = Trusted("node-agent", "code", "%%node agent.py\n# TODO", solution=True)
TEST = Trusted("ex-wiring", "code", 'check("1:wiring")', points=5.0)
ANSWER = Trusted("quiz-1", "markdown", "*Your answer:*", points=3.0, solution=True)
TASK = Trusted("task-1", "markdown", "Draw it.", points=2.0, task=True)
TRUSTED = [NODE, TEST, ANSWER]

MINE = Cell("code", "%%node agent.py\nmine", "node-agent")
CHECK = Cell("code", 'check("1:wiring")', "ex-wiring")
WRITTEN = Cell("markdown", "Because.", "quiz-1")


def by_name(notebook: Any) -> dict[str, Any]:
    found = [cell for cell in notebook.cells if "nbgrader" in cell.metadata]
    names = [cell.metadata.nbgrader.grade_id for cell in found]
    assert len(names) == len(set(names)), "each of nbgrader's cells once"
    nbformat.validate(notebook)
    return dict(zip(names, found, strict=True))


def test_an_honest_notebook_stays_as_it_is() -> None:
    cells = [Cell("markdown", "# Title"), MINE, CHECK, WRITTEN, Cell("code", "1 + 1")]
    made = restored(cells, TRUSTED)
    assert [cell.source for cell in made.cells] == [cell.source for cell in cells]
    assert set(by_name(made)) == {"node-agent", "ex-wiring", "quiz-1"}


def test_changed_tests_are_as_released_and_deleted_cells_come_back() -> None:
    made = by_name(restored([Cell("markdown", "check = print", "ex-wiring")], TRUSTED))
    cell = made["ex-wiring"]
    assert (cell.cell_type, cell.source) == ("code", 'check("1:wiring")')
    assert (cell.metadata.nbgrader.points, cell.metadata.nbgrader.locked) == (5.0, True)
    assert made["node-agent"].source == made["quiz-1"].source == ""
    assert made["quiz-1"].metadata[ABOUT]["missing"]


def test_of_copies_the_last_that_was_written_in_counts() -> None:
    untouched = Cell("markdown", ANSWER.source, "quiz-1")
    cells = [Cell("markdown", "old", "quiz-1"), Cell("markdown", "new", "quiz-1"), untouched]
    made = restored([*cells, CHECK, CHECK], TRUSTED)
    assert by_name(made)["quiz-1"].source == "new"
    assert [cell.source for cell in made.cells[:3]] == ["old", "new", ANSWER.source]


@pytest.mark.parametrize(
    ("cell", "kind", "source", "about"),
    [
        (Cell("markdown", f"{ANSWER.source}\n", "quiz-1"), "markdown", None, {"untouched": True}),
        (Cell("code", "Because.", "quiz-1"), "markdown", "Because.", {"was": "code"}),
        (Cell("raw", "%%node agent.py\na < b"), "code", None, {"was": "raw"}),
        (Cell("code", "x", "my-own-points"), "code", "x", {"was": "code"}),
    ],
)
def test_untouched_retyped_and_unknown_cells(
    cell: Cell, kind: str, source: str | None, about: dict[str, Any]
) -> None:
    notebook = restored([cell], TRUSTED)
    made = notebook.cells[0]
    assert (made.cell_type, made.source) == (kind, cell.source if source is None else source)
    assert about.items() <= made.metadata[ABOUT].items()
    assert set(by_name(notebook)) == {"node-agent", "ex-wiring", "quiz-1"}


def test_tasks_are_kept() -> None:
    made = by_name(restored([Cell("markdown", "Done!", "task-1")], [TASK]))["task-1"]
    assert made.source == "Draw it."
    assert made.metadata.nbgrader.task
    assert not made.metadata.nbgrader.grade


def test_an_unreadable_notebook_has_every_cell_for_a_person() -> None:
    made = unreadable("this is <b>no</b> JSON", TRUSTED)
    assert set(by_name(made)) == {"node-agent", "ex-wiring", "quiz-1"}
    assert made.metadata[ABOUT]["problem"] == "this is <b>no</b> JSON"
    assert "this is <b>no</b> JSON" in made.cells[0].source  # which its page sanitises


def test_too_much_text_is_left_out() -> None:
    cells = [Cell("markdown", "x" * 90_000)] * 60 + [MINE]
    made = restored(cells, TRUSTED)
    assert sum(len(cell.source) for cell in made.cells) < 4_100_000
    assert made.cells[59].source == "(left out: too long)"
    assert by_name(made)["node-agent"].source.endswith("mine")


@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.builds(
            Cell,
            st.sampled_from(["code", "markdown", "raw"]),
            st.sampled_from(["", "%%node agent.py\nx", 'check("1:wiring")', "text", "<b>"]),
            st.sampled_from(["", "node-agent", "ex-wiring", "quiz-1", "task-1", "other"]),
        ),
        max_size=12,
    )
)
def test_any_jumble_of_cells_gives_each_trusted_cell_once(cells: list[Cell]) -> None:
    made = by_name(restored(cells, [*TRUSTED, TASK]))
    assert set(made) == {"node-agent", "ex-wiring", "quiz-1", "task-1"}
    assert made["ex-wiring"].source == TEST.source


# --- what is no honest file ----------------------------------------------------------------


def written(folder: Path, content: Any) -> Path:
    path = folder / "notebook.ipynb"
    data = content if isinstance(content, bytes) else json.dumps(content).encode()
    path.write_bytes(data)
    return path


@pytest.mark.parametrize(
    "data",
    [
        b"", b"[]", b'{"cells": 3}', b'{"cells": ["x", null, 7]}', b'{"cells": NaN}',
        b'{"cells": [' + b"[" * 100_000, b"\xff\xfe\x00",
    ],
)  # fmt: skip
def test_what_is_no_notebook_is_unreadable(tmp_path: Path, data: bytes) -> None:
    with pytest.raises(FileReader.Refused):
        read_cells(written(tmp_path, data))


@pytest.mark.parametrize("part", ["{},", "[],", '"","",'])
def test_a_notebook_of_empty_parts_takes_no_memory(tmp_path: Path, part: str) -> None:
    many = f'{{"cells":[{part * intake.MAX_NESTED * 4}{{}}]}}'
    with pytest.raises(FileReader.Refused, match="far more parts"):
        read_cells(written(tmp_path, many.encode()))


def test_links_pipes_and_huge_files_are_not_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "secret").write_text('{"cells": [{"source": "the instructor\'s"}]}')
    (tmp_path / "link.ipynb").symlink_to(tmp_path / "secret")
    os.mkfifo(tmp_path / "pipe.ipynb")
    (tmp_path / "folder.ipynb").mkdir()
    for name in ("link", "pipe", "folder", "missing"):
        with pytest.raises(FileReader.Refused):
            read_cells(tmp_path / f"{name}.ipynb")
    monkeypatch.setattr(intake, "MAX_NOTEBOOK", 1000)
    path = written(tmp_path, {"cells": [{"source": "x", "outputs": ["y" * 1000]}]})
    with pytest.raises(FileReader.Refused, match="clear its outputs"):
        read_cells(path)


CODE = {"cell_type": "code", "source": "1"}
INVALID = (None, "x", [], {"nbgrader": []}, {"nbgrader": {"grade_id": ["quiz-1"]}})
SHEET = json.dumps({"worksheets": [{"cells": [{"cell_type": "code", "input": "x"}]}]})


@pytest.mark.parametrize(
    ("content", "cells"),
    [
        ({"cells": [CODE | {"outputs": [{"text": "y" * 5_000_000}]}]}, [Cell("code", "1")]),
        *(({"cells": [CODE | {"metadata": one}], "metadata": 9}, [Cell("code", "1")])
          for one in INVALID),
        ({"cells": [CODE | {"source": ["a\n", 7, "b"]}]}, [Cell("code", "a\nb")]),
        ({"cells": [{"cell_type": ["code"], "source": {"a": 1}}]}, [Cell("raw", "")]),
        ({"cells": [{"cell_type": "heading", "source": "x"}]}, [Cell("raw", "x")]),
        (b"\xef\xbb\xbf" + SHEET.encode(), [Cell("code", "x")]),  # an old one, with a BOM
        (rb'{"cells": [{"cell_type": "markdown", "source": "\ud800!"}]}', [Cell("markdown", "?!")]),
    ],
)  # fmt: skip
def test_odd_notebooks_are_read(tmp_path: Path, content: Any, cells: list[Cell]) -> None:
    assert read_cells(written(tmp_path, content)) == cells


def test_a_node_that_is_too_long_is_not_cut_to_size(tmp_path: Path) -> None:
    source = "%%node agent.py\n" + "#" * (3 * MAX_SIZE)
    cells = read_cells(written(tmp_path, {"cells": [{"cell_type": "code", "source": source}]}))
    made = definition(restored(cells, TRUSTED).cells[0].source)
    assert made is not None
    assert len(made.text) > MAX_SIZE  # which the judge refuses


def test_pasted_pictures_stay_and_other_attachments_go(tmp_path: Path) -> None:
    kept = {"a.png": {"image/png": "aGk="}}
    given_ = {**kept, "b": {"text/html": "<b>"}, "c.png": {"image/png": '"><script>'}, "d": 3}
    cell = {"cell_type": "markdown", "source": "x", "attachments": given_}
    found = read_cells(written(tmp_path, {"cells": [cell]}))
    assert found[0].pictures == kept
