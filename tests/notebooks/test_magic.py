"""`%%node` in a real kernel: files are written as they stand, or not at all."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from kernels import Kernel

from grader.nbgrader.cells import Definition, definition
from grader.notebook.cells import CellProblem, check_syntax, file_name

HOSTILE = "<script>alert('x')</script>"


def test_the_cell_becomes_the_file(kernel: Kernel, folder: Path) -> None:
    said = kernel.run("%%node agent.py\nx = 1\n\ny = 'ö'")
    assert (folder / "agent.py").read_bytes() == "x = 1\n\ny = 'ö'\n".encode()
    assert said.text.strip() == "Saved agent.py (3 lines)."
    assert said.stderr == ""
    assert list(folder.glob(".*")) == []  # nothing half-written stays


@pytest.mark.parametrize(
    "cell",
    [
        "%%node agent.py\nx = 1",
        "\n \n%%node agent.py\nx = 1\n",
        "  %%node agent.py\n  if True:\n      x = 2\n",
        "%%node   agent.py  \nx = '''\n%%node other.py\n'''",
        '%%node "agent.py"\n# nothing but words\n',
    ],
)
def test_the_plug_in_reads_what_the_kernel_writes(kernel: Kernel, folder: Path, cell: str) -> None:
    file = folder / "agent.py"
    file.unlink(missing_ok=True)
    kernel.run(cell)
    read = definition(cell)
    assert read is not None
    assert read.file == "agent.py"
    assert file.read_text("utf-8") == read.text


def test_a_syntax_error_keeps_the_file_and_says_where(kernel: Kernel, folder: Path) -> None:
    kernel.run("%%node agent.py\nx = 1\n")
    said = kernel.run("%%node agent.py\nimport math\ndef f(:\n    pass\n")
    assert (folder / "agent.py").read_text() == "x = 1\n"
    lines = said.stdout.splitlines()
    assert lines[0] == "Not saved: agent.py, line 2 (line 3 of the cell): invalid syntax"
    assert lines[1:3] == ["    def f(:", "          ^"]
    assert lines[3] == "Correct the cell and run it again. agent.py on disk is unchanged."
    assert said.stderr == ""


def test_nothing_is_judged_by_an_older_file_than_the_cell(kernel: Kernel) -> None:
    kernel.run("%%node obstacle_avoidance_agent.py\nx = 1\n")
    kernel.run("%%node obstacle_avoidance_agent.py\nx = (\n")
    for cell in ("check()", "check('1')", "drive('demo_wall')"):
        said = kernel.run(cell)
        assert said.stdout.startswith("Not ")
        assert "the last %%node obstacle_avoidance_agent.py cell was not saved" in said.stdout
        assert "was never closed" in said.stdout
    kernel.run("%%node obstacle_avoidance_agent.py\nx = 1\n")
    assert "0 / 100" in kernel.run("check('1')").text


@pytest.mark.parametrize(
    ("words", "advice"),
    [
        ("", "got nothing"),
        ("../agent.py", "leave out the folder"),
        ("agent", "write “%%node agent.py”"),
        (".py", "“%%node my_node.py”"),
        ("agent.py # mine", "write “%%node agent.py”"),
        ("random.py", "would hide the module random"),
    ],
)
def test_other_names_are_refused(kernel: Kernel, folder: Path, words: str, advice: str) -> None:
    before = sorted(folder.iterdir())
    said = kernel.run(f"%%node {words}\nx = 1\n")
    assert said.stdout.startswith("Not saved: ")
    assert advice in said.stdout
    assert sorted(folder.iterdir()) == before


def test_students_text_is_text_in_the_page(kernel: Kernel) -> None:
    said = kernel.run(f'%%node agent.py\ns = "{HOSTILE}"\n')
    assert "<script" not in said.html
    assert "alert" in said.html  # it is shown
    refused = kernel.run(f"%%node {HOSTILE}\nx = 1\n")
    assert refused.html == ""  # plain text
    assert HOSTILE in refused.stdout


def test_import_star_registers_the_magic_too(kernel: Kernel, folder: Path) -> None:
    code = (
        "from IPython.core.interactiveshell import InteractiveShell as Shell\n"
        "shell = Shell.instance()\n"
        "shell.run_cell('from grader.notebook import *')\n"
        "assert shell.run_cell('%%node star.py\\nx = 1').success\n"
        "print(open('star.py').read())\n"
    )
    environment = {**os.environ, "IPYTHONDIR": str(folder / "ipython")}
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder, env=environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout == "Saved star.py (1 line).\nx = 1\n\n"


def test_the_package_imports_nothing_heavy() -> None:
    code = "import sys, grader.notebook; print([m for m in sys.modules if m in %r])"
    heavy = ("rclpy", "numpy", "IPython", "matplotlib", "rich", "pytest")
    done = subprocess.run(
        [sys.executable, "-c", code % (heavy,)], capture_output=True, text=True, check=True
    )
    assert done.stdout == "[]\n"


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("%matplotlib inline\n", "notebook commands (% and !) don't belong in a file"),
        ("await x\n", "'await' outside function"),
        ("x = 1\n\ty = 2\n", "unexpected indent"),
        ("x = '\0'\n", "null bytes"),
        ("x = '\ud800'\n", "no text file"),
        ("(" * 5000 + "\n", ""),
        ("\n  \n", "empty"),
    ],
)
def test_what_python_cannot_read_is_a_problem(source: str, said: str) -> None:
    with pytest.raises(CellProblem) as caught:
        check_syntax(Definition("agent.py", source))
    assert said in caught.value.text


@given(st.text(max_size=200))
def test_any_text_is_read_or_explained(source: str) -> None:
    try:
        check_syntax(Definition("agent.py", source + "\n"))
    except CellProblem as problem:
        assert problem.text


@given(st.text(max_size=60))
def test_any_name_is_taken_or_explained(words: str) -> None:
    try:
        name = file_name(words)
    except CellProblem as problem:
        assert "expected the name of a Python file" in problem.text
    else:
        assert Path(name).name == name
        assert name.endswith(".py")
