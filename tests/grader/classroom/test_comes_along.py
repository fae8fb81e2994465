"""Modules, data and packages reach the judge through every platform's format."""

import json
from pathlib import Path

import pytest
from handing_in import AGENT as FILE
from handing_in import put, taken

from grader.classroom.intake.candidates import find_class
from grader.classroom.intake.exercise_files import find_files
from grader.classroom.options import Options

SLUG = "obstacle_avoidance"
NODE = {FILE: b"import kit.eyes", "kit/eyes.py": b"1", "kit/a.yaml": b"2"}
PACKAGE = {
    "package.xml": b"<package/>",
    "setup.py": b"",
    "mine/__init__.py": b"",
    f"mine/{FILE}": b"node",
    "mine/eyes.py": b"eyes",
    "launch/a.launch.py": b"",
}


BARE = {name: data for name, data in PACKAGE.items() if not name.endswith("__init__.py")}
PLACES = {  # where a platform's download has what Ann handed in: a folder, or an archive of it
    "folders": "ann",
    "archives": "ann.zip",
    "canvas": "leeann_12_345_work.zip",
    "moodle": "Ann Lee_4321_assignsubmission_file_",
    "moodle, zipped": "Ann Lee_4321_assignsubmission_file_/work.zip",
    "nbgrader": "submitted/ann/week1",
    "github": "week-1-ann",
}


@pytest.mark.parametrize("files", [NODE, PACKAGE, BARE], ids=["beside", "package", "bare"])
@pytest.mark.parametrize("place", PLACES)
def test_through_each_platforms_format(place: str, files: dict[str, bytes], tmp_path: Path) -> None:
    target = tmp_path / "in" / PLACES[place]
    if place == "nbgrader":
        (tmp_path / "in" / "source").mkdir(parents=True)
    built = {"build/COLCON_IGNORE": b"", f"build/mine/{FILE}": b"old"}
    put(target, **files, **built)
    (student,) = taken(tmp_path / "in").students
    found = find_files(student, [FILE])

    assert {name: path.read_bytes() for name, path in found.every.items()} == files
    assert [path.name for path in found.files.values()] == [FILE]


@pytest.mark.parametrize("files", [NODE, PACKAGE], ids=["beside", "package"])
def test_what_a_work_needs_is_no_missing_exercise(files: dict[str, bytes], tmp_path: Path) -> None:
    """Ben handed in another exercise, so Ann may have it under another name."""
    put(tmp_path / "in" / "ann" / "ws", **files)
    put(tmp_path / "in" / "ann", **{"goal.py": "import goal_seeking"})
    put(tmp_path / "in" / "ben", **{"goal_seeking_agent.py": "work = 1"})
    account = find_class([tmp_path / "in"], tmp_path / "scratch", Options()).account
    assert [line.file for line in account.faults] == ["goal.py"]


def test_single_files_of_canvas_newest_first(tmp_path: Path) -> None:
    files = {
        f"leeann_12_345_{FILE}": "old", f"leeann_12_346_{FILE[:-3]}-1.py": "new",
        "leeann_12_347_eyes-1.py": "eyes", "leeann_12_348_model-2.onnx": "m",
        "benbob_13_349_eyes.py": "ben's",
    }  # fmt: skip
    student = taken(put(tmp_path / "in", **files)).students[-1]
    every = {name: path.read_bytes() for name, path in find_files(student, [FILE]).every.items()}
    assert every == {
        FILE: b"new", "eyes.py": b"eyes", "model-2.onnx": b"m", "model.onnx": b"m"
    }  # fmt: skip


def test_a_notebooks_cells_and_what_lies_beside_it(tmp_path: Path) -> None:
    cells = [
        {"cell_type": "code", "source": f"%%node {name}\n{text}", "metadata": {}}
        for name, text in ((FILE, "import eyes"), ("eyes.py", "SEEN = 1"), ("../out.py", "no"))
    ]
    book = json.dumps({"nbformat": 4, "nbformat_minor": 5, "metadata": {}, "cells": cells})
    put(tmp_path / "in" / "ann", **{"a.ipynb": book, "model.onnx": "m"})
    (student,) = taken(tmp_path / "in").students
    assert set(find_files(student, [FILE]).every) == {FILE, "eyes.py", "model.onnx"}
