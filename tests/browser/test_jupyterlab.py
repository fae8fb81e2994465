"""A student's notebook in a real JupyterLab: Run All, the table of checks, the replay.

The first notebook as it is released, once with the solution and once with a mistake in it.
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("nbformat", reason="nbformat is not installed (the extra `notebooks`)")

from frames import pixels, value, wait_until
from lab_server import Server, Tab, picture, serving, tab
from nbgrader_kit import FULL, cell_named, fill, make_course, released, solution, source_of

from grader.claims.mutants import find_mutant
from grader.course.exercises import find_exercise

NEEDED = ("jupyterlab", "ipykernel", "nbgrader", "matplotlib")
LACKS = [name for name in NEEDED if find_spec(name) is None]
pytestmark = [
    pytest.mark.skipif(bool(LACKS), reason=f"not installed: {LACKS} (the extra `notebooks`)"),
]
NAME = "01_loop"
SLUG = "obstacle_avoidance"
FILE = "obstacle_avoidance_agent.py"
MISTAKE = "nan_poisons_min"  # one of exercise 1's mutants
FAILS = f"{SLUG}-infinite_readings"
# Cells that are run before that are forgotten, though the kernel is called idle.
KERNEL_ANSWERS = """async () => {
  const { sessionContext } = jupyterapp.shell.currentWidget;
  await sessionContext.ready;
  await sessionContext.session.kernel.info;
  await sessionContext.session.kernel.requestExecute({ code: '', silent: true }).done;
}"""
DRAWN = "window.replayPlayer && document.querySelector('canvas.map').clientWidth > 100"


@dataclass
class Opened:
    """A notebook in a tab."""

    tab: Tab
    cells: list[dict[str, Any]]

    @property
    def page(self) -> Any:
        return self.tab.page

    def cell(self, number: int) -> Any:
        """The cell as JupyterLab shows it."""
        return self.page.locator(".jp-Notebook .jp-Cell").nth(number)

    def named(self, grade_id: str) -> Any:
        """The cell that nbgrader knows by this name."""
        return self.cell(self.cells.index(cell_named({"cells": self.cells}, grade_id)))

    def beginning(self, text: str) -> Any:
        """The cell whose source begins so."""
        return self.cell(next(n for n, c in enumerate(self.cells) if source_of(c).startswith(text)))

    def run_all(self) -> None:
        """Do as students do, and wait for the kernel to be idle."""
        self.page.evaluate(KERNEL_ANSWERS)
        self.page.get_by_role("menuitem", name="Run", exact=True).click()
        self.page.get_by_role("menuitem", name="Run All Cells", exact=True).click()
        count = sum(cell["cell_type"] == "code" for cell in self.cells)
        last = max(n for n, cell in enumerate(self.cells) if cell["cell_type"] == "code")
        prompt = self.cell(last).locator(".jp-InputPrompt")
        self.page.wait_for_function(
            "([prompt, said]) => prompt.textContent.trim() === said",
            arg=[prompt.element_handle(), f"[{count}]:"],
        )
        self.page.wait_for_selector('.jp-Notebook-ExecutionIndicator[data-status="idle"]')


@pytest.fixture(scope="module")
def work(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A student's folder: the released notebook, solved well and badly, each in its own."""
    course = make_course(tmp_path_factory.mktemp("course"), [NAME])
    folder = tmp_path_factory.mktemp("student")
    mutant = find_mutant(find_exercise(SLUG), MISTAKE)
    texts = {"right": solution(SLUG, FILE), "wrong": mutant.text}
    for name, text in texts.items():
        notebook = fill(released(course, NAME), {FILE: text})
        (folder / name).mkdir()
        (folder / name / f"{NAME}.ipynb").write_text(json.dumps(notebook), "utf-8")
    return folder


@pytest.fixture(scope="module")
def server(work: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    with serving(work, tmp_path_factory.mktemp("jupyter")) as running:
        yield running


def opened(browser: Any, server: Server, which: str) -> Iterator[Opened]:
    path = f"{which}/{NAME}.ipynb"
    cells = json.loads((server.folder / path).read_text("utf-8"))["cells"]
    with tab(browser, server) as there:
        notebook = Opened(there, cells)
        there.page.goto(server.address(f"lab/workspaces/{which}/tree/{path}"))
        there.page.wait_for_selector('.jp-Notebook-ExecutionIndicator[data-status="idle"]')
        there.page.wait_for_function(
            "(count) => document.querySelectorAll('.jp-Notebook .jp-Cell').length === count",
            arg=len(cells),
        )
        notebook.run_all()
        yield notebook


@pytest.fixture(scope="module")
def right(browser: Any, server: Server) -> Iterator[Opened]:
    """The solved notebook after Run All."""
    if not FULL:
        pytest.skip("the solved notebook in JupyterLab: make notebooks")
    yield from opened(browser, server, "right")


@pytest.fixture(scope="module")
def wrong(browser: Any, server: Server) -> Iterator[Opened]:
    """The notebook with a mistake in it after Run All."""
    yield from opened(browser, server, "wrong")


def replay_in(cell: Any) -> Any:
    """The player in a cell's frame, drawn."""
    element = cell.locator("iframe.course-replay").element_handle()
    element.scroll_into_view_if_needed()
    frame = element.content_frame()
    frame.wait_for_selector("canvas.map")
    wait_until(frame, DRAWN)
    return frame


def chips(cell: Any) -> list[str]:
    return [text.strip() for text in cell.locator(".course-check .chip").all_text_contents()]


def complaints_in_cells(notebook: Opened) -> list[str]:
    """What stands in red below cells: errors, and stderr."""
    found = notebook.page.locator(
        ".jp-Notebook [data-mime-type*='.stderr'], [data-mime-type*='.error']"
    )
    return [str(text) for text in found.all_text_contents()]


def panel(page: Any) -> Any:
    """Where the notebook is on the screen, without Jupyter's bars around it."""
    return page.locator(".jp-WindowedPanel-outer").bounding_box()


def change_theme(page: Any, name: str) -> None:
    """Choose JupyterLab Light or Dark."""
    page.evaluate(
        "(theme) => jupyterapp.commands.execute('apputils:change-theme', {theme})",
        f"JupyterLab {name}",
    )
    light = str(name == "Light").lower()
    page.wait_for_selector(f"body[data-jp-theme-light='{light}']", state="attached")


# --- the solution --------------------------------------------------------------------------


def test_a_replay_plays(right: Opened) -> None:
    cell = right.beginning('drive("avoid_cart")')
    frame = replay_in(cell)
    assert value(frame, "time") == 0
    before = pixels(frame)

    frame.locator("canvas.map").focus()
    right.page.keyboard.press("Space")
    wait_until(frame, "window.replayPlayer.time > 0.3")
    right.page.keyboard.press("Space")

    assert value(frame, "playing") is False
    assert pixels(frame) != before
    value(frame, "seek(5.5)")
    cell.evaluate("(e) => e.scrollIntoView({block: 'start'})")
    wait_until(right.page, "true")
    picture(right.page, "notebook-light", panel(right.page))


def test_all_of_it_turns_dark_with_jupyterlab(right: Opened) -> None:
    page = right.page
    frame = replay_in(right.beginning('drive("avoid_cart")'))
    dark = "matchMedia('(prefers-color-scheme: dark)').matches"
    assert frame.evaluate(dark) is False

    change_theme(page, "Dark")
    wait_until(frame, dark)
    every = right.beginning(f'check("{SLUG}", field=True)')
    plot = right.beginning("show_scan(").locator("img.course-plot")
    assert "invert" in plot.evaluate("(e) => getComputedStyle(e).filter")
    plot.evaluate("(e) => e.scrollIntoView({block: 'center'})")
    every.evaluate("(e) => e.scrollIntoView({block: 'start'})")
    wait_until(page, "true")
    picture(page, "notebook-dark", panel(page))
    change_theme(page, "Light")  # the server keeps it for other notebooks too
    wait_until(frame, f"!{dark}")


# --- a mistake -----------------------------------------------------------------------------


def test_a_failed_check_is_named_and_its_replay_stands_at_the_moment(wrong: Opened) -> None:
    assert complaints_in_cells(wrong) == []
    assert set(chips(wrong.named(f"{SLUG}-wiring"))) == {"✓ pass"}
    cell = wrong.named(FAILS)
    assert "✗ FAIL" in chips(cell)
    table = cell.locator("table.checks").text_content()
    assert "expected" in table
    assert cell.locator("details[open] > summary", has_text="Replay of what failed").count() == 1

    frame = replay_in(cell)
    wait_until(frame, "!window.replayPlayer.playing && window.replayPlayer.time > 0")
    annotation = frame.locator(".annotation")
    assert annotation.is_visible()
    title = annotation.inner_text().split("\n")[0]
    assert title
    assert title in table
    cell.evaluate("(e) => e.scrollIntoView({block: 'start'})")
    wait_until(wrong.page, "true")
    picture(wrong.page, "notebook-wrong", panel(wrong.page))
