"""Files as people give them: notebooks, archives, second copies, letters that are not UTF-8."""

import shutil
import zipfile
from pathlib import Path

import nbformat
import pytest
from command_line import course
from nbformat import v4

from grader.cli.given import as_files, wanted_in
from grader.course.exercises import find_exercise
from grader.course.submission import find_submission
from grader.errors import InputError

EXERCISE = find_exercise("ml_velocity")
NODE, TRAINING = EXERCISE.files


def notebook(path: Path, *cells: str) -> Path:
    nbformat.write(v4.new_notebook(cells=[v4.new_code_cell(text) for text in cells]), path)
    return path


def taken(path: Path) -> dict[str, str]:
    """What the node finds in its working folder, the node's file first."""
    with as_files(path, EXERCISE.files) as given:
        submission = find_submission(given, NODE, (TRAINING,))
        assert submission.problem == ""
        contents = {name: text.decode() for name, text in submission.contents().items()}
        first = submission.path.name
    return {first: contents.pop(first), **contents}


def test_a_notebook_is_what_its_cells_write(tmp_path: Path) -> None:
    (tmp_path / "features.py").write_text("old")
    (tmp_path / "data.npz").write_text("data")
    cells = (f"%%node {NODE}\nnode", "%%node features.py\nnew", "print(1)", f"%%node {TRAINING}\nt")
    wanted = {NODE: "node\n", TRAINING: "t\n", "features.py": "new\n", "data.npz": "data"}
    assert taken(notebook(tmp_path / "02 a (1).ipynb", *cells)) == wanted
    assert taken(notebook(tmp_path / "x.ipynb", "%%node mine.py\nnode"))["mine.py"] == "node\n"


@pytest.mark.parametrize(
    ("cells", "said"),
    [
        (["import rclpy"], r"x\.ipynb: expected a cell that begins with `%%node ml_velocity"),
        (["%%node goal_seeking_agent.py\n1"], r"its cells write goal_seeking_agent\.py"),
    ],
)
def test_a_notebook_without_the_node_says_so(tmp_path: Path, cells: list[str], said: str) -> None:
    with pytest.raises(InputError, match=said):
        taken(notebook(tmp_path / "x.ipynb", *cells))


@pytest.mark.parametrize("inside", ["", "week 2/", "a/b/"])
@pytest.mark.parametrize("marks", [("", ""), (" (1)", " (1)"), (" - Copy", ""), ("", " (2)")])
def test_zipped_folders_and_second_copies(
    tmp_path: Path, inside: str, marks: tuple[str, str]
) -> None:
    named = {
        name: name.replace(".py", f"{mark}.py")
        for name, mark in zip(EXERCISE.files, marks, strict=True)
    }
    with zipfile.ZipFile(tmp_path / "mine.zip", "w") as archive:
        for name in (NODE, TRAINING):
            archive.writestr(f"{inside}{named[name]}", name)
        archive.writestr(f"{inside}features.py", "f")
        archive.writestr("__MACOSX/x", "")
    wanted = {NODE: NODE, TRAINING: TRAINING, "features.py": "f"}
    assert taken(tmp_path / "mine.zip") == wanted
    shutil.unpack_archive(tmp_path / "mine.zip", tmp_path / "open")
    folder = tmp_path / "open" / inside
    assert taken(folder) == wanted
    assert taken(folder / named[NODE]) == wanted


def test_of_several_copies_the_last_counts_or_the_one_that_is_given(tmp_path: Path) -> None:
    for number in (1, 2, 10):
        (tmp_path / NODE.replace(".py", f" ({number}).py")).write_text(str(number))
    assert taken(tmp_path / NODE.replace(".py", " (1).py"))[NODE] == "1"
    (tmp_path / NODE).write_text("0")
    assert taken(tmp_path)[NODE] == "0"
    (tmp_path / "my node (3).py").write_text("3")
    assert next(iter(taken(tmp_path / "my node (3).py").values())) == "3"


@pytest.mark.parametrize("name", ["x.zip", "x.ipynb", "x.tar.gz"])
def test_a_broken_file_takes_one_line(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(b"\xff" * 100)
    with pytest.raises(InputError, match=f"{name}: cannot be read") as caught:
        taken(tmp_path / name)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("start", "problem"),
    [
        ("# Grüße\n".encode("latin-1"), "line 1 has a letter that is not UTF-8; save the file as"),
        ("\n# é\n".encode("utf-16"), "line 1 has a letter"),
        ("# -*- coding: latin-1 -*-\n# Grüße\n".encode("latin-1"), ""),
        ("\ufeff# Grüße\n".encode(), ""),
    ],
)
def test_letters_that_are_not_utf_8(tmp_path: Path, start: bytes, problem: str) -> None:
    (tmp_path / NODE).write_bytes(start + b"pass\n")
    found = find_submission(tmp_path / NODE).problem
    assert found.startswith(problem) and bool(found) == bool(problem)


def test_a_skeleton_says_that_it_is_one_and_what_comes_first(tmp_path: Path) -> None:
    for name in EXERCISE.files:
        shutil.copy(EXERCISE.folder / name, tmp_path / name)
    said = find_submission(tmp_path, NODE, (TRAINING,)).account()
    assert said[0] == "This is still the skeleton: task 1 is “Wire the node”."
    (tmp_path / NODE).write_text("pass")
    said = find_submission(tmp_path, NODE, (TRAINING,)).account()
    assert said == [f"Still the skeleton: {TRAINING}."]
    (tmp_path / TRAINING).unlink()
    assert find_submission(tmp_path, NODE, (TRAINING,)).account() == []


def test_the_commands_take_them(tmp_path: Path) -> None:
    exercise = find_exercise("obstacle_avoidance")
    (file,) = exercise.files
    text = (exercise.solutions / file).read_text("utf-8")
    given = notebook(tmp_path / "my loop (1).ipynb", f"%%node {file}\n{text}")
    assert course("grade", "1", given, "--only", "wiring", "--json", "-").json["score"] == 5
    drove = course("drive", given, "--scenario", "avoid_wall", "--duration", "1")
    assert (drove.code, "Distance: " in drove.out) == (0, True), drove.err
    assert wanted_in("goal_changes")[0] == "goal_seeking_agent.py"
