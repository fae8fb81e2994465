"""A notebook saved as a program is read, or a person looks; other programs stay what they are."""

from pathlib import Path

import jupytext
import nbformat
import pytest
from nbconvert import PythonExporter
from nbformat import NotebookNode, v4

from grader.classroom.intake.exercise_files import find_files, find_sole
from grader.classroom.intake.handed_in import Student
from grader.classroom.intake.students import take_in
from grader.cli.given import as_files
from grader.errors import InputError

FILE = "obstacle_avoidance_agent.py"
TEXT = "# from scratch\nimport rclpy\n\n\nclass A:\n    '''\n%%node b.py\n'''\n\n    # %% of a cell"


def colab(notebook: NotebookNode) -> str:  # as its Download .py has it
    cells = []
    for cell in notebook.cells:
        magic = cell.source.startswith("%%")
        text = "\n".join(f"# {line}" for line in cell.source.split("\n")) if magic else cell.source
        head = "# Commented out IPython magic to ensure Python compatibility.\n" if magic else ""
        cells.append(f'"""{text}\n"""' if cell.cell_type == "markdown" else head + text)
    return "\n\n".join(cells)


FORMS = {
    "script": lambda book: PythonExporter().from_notebook_node(book)[0],
    "colab": colab,
    "renamed": nbformat.writes,
    **{each: lambda book, form=each: jupytext.writes(book, f"py:{form}")
       for each in ("percent", "hydrogen", "light", "sphinx", "nomarker")},
}  # fmt: skip
UNTOLD = ("light", "sphinx", "nomarker")  # nobody can tell where a cell ends


def saved(folder: Path, form: str, magic: str, name: str) -> Path:
    first = v4.new_code_cell("from grader.notebook import *; prepare()")
    texts = (f"{magic} {FILE}\n{TEXT}", f"{magic} see/eyes.py\nimport math", 'check("1")')
    cells = [v4.new_markdown_cell("# Loop"), first, *map(v4.new_code_cell, texts)]
    return put(folder / "in" / "ann" / name, FORMS[form](v4.new_notebook(cells=cells)))


def put(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True)
    path.write_text(text, "utf-8")
    return path


def handed_in(folder: Path) -> Student:
    return take_in([folder / "in"], folder / "scratch").students[0]


@pytest.mark.parametrize(("name", "magic"), [("01_loop.py", "%%node"), (FILE, "%%writefile")])
@pytest.mark.parametrize("form", [form for form in FORMS if form not in UNTOLD])
def test_its_cells_are_read(tmp_path: Path, form: str, name: str, magic: str) -> None:
    path = saved(tmp_path, form, magic, name)
    for given in (path, path.parent) if name == FILE else (path,):
        with as_files(given, [FILE]) as file:
            assert (file.name, file.read_text("utf-8").rstrip()) == (FILE, TEXT)
            assert (file.parent / "see" / "eyes.py").read_text() == "import math\n"
    found = find_files(handed_in(tmp_path), [FILE])
    assert found.files[FILE].read_text("utf-8").rstrip() == TEXT
    assert set(found.every) == {FILE, "see/eyes.py"}


@pytest.mark.parametrize("name", ["01_loop.py", FILE])
@pytest.mark.parametrize("form", UNTOLD)
def test_where_nobody_can_tell_a_person_looks(tmp_path: Path, form: str, name: str) -> None:
    path = saved(tmp_path, form, "%%node", name)
    said = r"a notebook saved as a program.* expected the notebook itself \(\.ipynb\)"
    with pytest.raises(InputError, match=said), as_files(path, [FILE]):
        pass
    found = find_sole(handed_in(tmp_path), [FILE])
    assert (found.files, "a notebook saved as a program" in found.problem) == ({}, True)


@pytest.mark.parametrize(
    "text",
    [f"# %%node {FILE}\nimport rclpy\n# %%\nx = 1\n", "# %%\nimport rclpy\n", f"%%node {FILE}\n1"],
)
def test_a_program_with_a_mere_comment_is_what_it_is(tmp_path: Path, text: str) -> None:
    path = put(tmp_path / "in" / "ann" / "mine.py", text)
    with as_files(path, [FILE]) as given:
        assert given == path
    assert find_sole(handed_in(tmp_path), [FILE]).files[FILE].read_text() == text
