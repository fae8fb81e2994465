"""The stop button, mistakes, and the end of a notebook's judge: nothing is left of it."""

import os
import sys
import tempfile
from pathlib import Path

import pytest
from kernels import Kernel, gone, save, started

from grader.course.exercises import SOLUTIONS

AGENT = "obstacle_avoidance_agent.py"
RIGHT = (SOLUTIONS / "obstacle_avoidance" / AGENT).read_text("utf-8")
HANGS = "while True:\n    pass\n"


@pytest.mark.long
@pytest.mark.parametrize("killed", [True, False])
def test_the_judge_ends_with_the_kernel_and_leaves_no_files(tmp_path: Path, killed: bool) -> None:
    argv = [sys.executable, "-m", "ipykernel_launcher"]
    with started(tmp_path, argv, **os.environ) as kernel:
        kernel.run("from grader.notebook import *\n")
        save(kernel, AGENT, "x = 1\n")
        kernel.run("check('1')")
        judge = kernel.judge()
        kernel.manager.shutdown_kernel(now=killed)
    assert gone(judge)
    assert killed or list(Path(tempfile.gettempdir()).glob(f"course-{judge}-*")) == []


def test_the_stop_button_ends_the_judge_and_the_node(kernel: Kernel) -> None:
    save(kernel, AGENT, RIGHT)
    kernel.run("check('1:wiring')")
    judge = kernel.judge()
    save(kernel, AGENT, HANGS)
    said = kernel.run("check()", when=lambda said: len(said.states) > 2)
    assert said.status == "ok"
    assert "Not checked: stopped, because you interrupted the kernel" in said.text
    assert gone(judge)
    assert list(Path(tempfile.gettempdir()).glob(f"course-{judge}-*")) == []
    save(kernel, AGENT, RIGHT)
    assert "Score  5 / 5" in kernel.run("check('1:wiring')").text


@pytest.mark.long
def test_a_judge_that_died_is_replaced(kernel: Kernel) -> None:
    save(kernel, AGENT, RIGHT)
    kernel.run("check('1:wiring')")
    judge = kernel.judge()
    os.kill(judge, 9)
    assert "Score  5 / 5" in kernel.run("check('1:wiring')").text


@pytest.mark.parametrize(
    ("cell", "expected"),
    [
        ("check('obstacle_avoidence')", "did you mean obstacle_avoidance?"),
        ("check('1:nope')", "unknown check 'nope'; there are: wiring"),
        ("check('1:')", "expected names of checks after the colon"),
        ("check('2')", "run the cell that starts with “%%node ml_velocity_controller.py” first"),
        ("check('1', file='nope.py')", "there is no nope.py here"),
        ("drive('demo_wal')", "did you mean 'demo_wall'?"),
        ("drive('nope.toml')", "no such scenario file"),
        ("drive('demo_wall', lidar='lds9')", "there are: default, lds01, lds02, wide"),
        ("drive('demo_wall', duration=-1)", "expected a time in seconds"),
        ("drive('demo_wall', goals=[1])", "expected pairs (x, y) [m]"),
        ("drive('demo_wall', at=99)", "at 99 s: expected a moment of the 15 s drive"),
        ("drive('demo_wall', params={'a b': 1})", "expected NAME:=VALUE"),
    ],
)
def test_mistakes_are_explained_without_a_traceback(
    kernel: Kernel, cell: str, expected: str
) -> None:
    save(kernel, AGENT, RIGHT)
    said = kernel.run(cell)
    assert (said.status, said.stderr, said.traceback) == ("ok", "", "")
    assert said.text.strip().startswith("Not ")
    assert expected in said.text


def test_a_file_of_no_exercise_can_be_driven_but_not_checked_without_a_name(kernel: Kernel) -> None:
    save(kernel, "my_node.py", RIGHT)
    assert "my_node.py in demo_wall" in kernel.run("drive('demo_wall')").text
    assert "say which exercise it is for" in kernel.run("check()").text
    assert "Score  5 / 5" in kernel.run("check('1:wiring', file='my_node.py')").text


def test_a_file_in_the_notebooks_folder_hides_no_module_from_the_judge(
    kernel: Kernel, folder: Path
) -> None:
    (folder / "random.py").write_text("raise SystemExit('this is not the real one')\n")
    try:
        save(kernel, AGENT, RIGHT)
        kernel.run("from grader.notebook.child import JUDGE\nJUDGE.end()")
        assert "Score  5 / 5" in kernel.run("check('1:wiring')").text
    finally:
        (folder / "random.py").unlink()
