"""The notebooks in JupyterLite, in a real browser: the built site, every other host leads nowhere.

The cells are those that students get; what is written into them is driven by the page's runtime and
judged in the notebook's kernel. Without `make lite` these tests are skipped.
"""

import json
import time
from pathlib import Path
from typing import Any

import pytest
from browsers import BROWSERS
from served_site import SLOW, served

from grader.claims.mutants import find_mutant
from grader.course.exercises import ROOT, all_exercises, find_exercise
from grader.course.submission import find_submission
from grader.grading.grading import grade_submission
from rclpy_virtual_time.link.hosts import ForkServer

MADE = ROOT / "build" / "lite" / "index.html"
WHOLE = [each.slug for each in all_exercises() if not each.libraries]  # a page judges all of them
MUTANTS = {
    "obstacle_avoidance": "narrow_cone",
    "goal_seeking": "yaw_in_degrees",
    "trend_memory": "whole_circle",
}
# Write cells (by how they begin; "" for one more at the end), run all; whether none runs any more
RUN = """(texts) => {
  const { content } = jupyterapp.shell.currentWidget;
  const cells = Array.from(content.model.cells);
  for (const [start, text] of Object.entries(texts)) {
    const cell = cells.find((each) => each.sharedModel.getSource().startsWith(start));
    if (start) cell.sharedModel.setSource(text);
    else content.model.sharedModel.addCell({ cell_type: 'code', source: text });
  }
  jupyterapp.commands.execute('notebook:run-all-cells');
}"""
OUTPUTS = """() => Array.from(jupyterapp.shell.currentWidget.content.model.cells)
  .filter(({ type }) => type === 'code').map((cell) => cell.outputs.toJSON())"""
SAYS = """
import json
report = check("{}")
print("SAID", json.dumps([[c["id"], c["outcome"], c["message"]] for c in report.checks]))
"""

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(
        not MADE.is_file(), reason="the site has no notebooks in the browser here: run `make lite`"
    ),
]


def said_at_the_end(page: Any, texts: dict[str, str]) -> str:
    """Run all cells of the notebook; return what its last one has printed."""
    page.locator(".jp-Notebook .jp-Cell").first.wait_for()
    page.wait_for_function("globalThis.jupyterapp?.shell.currentWidget?.sessionContext.isReady")
    page.evaluate(RUN, texts)
    until = time.monotonic() + SLOW / 1000
    while True:
        outputs = page.evaluate(OUTPUTS)
        failed = [out for cell in outputs for out in cell if out["output_type"] == "error"]
        assert failed == [] and time.monotonic() < until
        _, found, said = "".join(out.get("text", "") for out in outputs[-1]).partition("SAID ")
        if found:
            return said
        page.wait_for_timeout(500)


@pytest.mark.parametrize(("slug", "mutant"), [*((slug, None) for slug in WHOLE), *MUTANTS.items()])
def test_a_notebook_runs_in_the_browser_and_judges_as_course_grade(
    open_served: Any, forkserver: ForkServer, tmp_path: Path, slug: str, mutant: str | None
) -> None:
    exercise = find_exercise(slug)
    (notebook,) = (ROOT / "notebooks" / "text").glob(f"{exercise.number:02}_*")
    files = {name: (exercise.solutions / name).read_text() for name in exercise.files}
    if mutant:
        files[exercise.files[0]] = find_mutant(exercise, mutant).text
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    submission = find_submission(tmp_path / exercise.files[0], others=exercise.files[1:])
    graded = grade_submission(exercise, submission, forkserver, file=exercise.files[0])
    assert (graded.score == 100) == (mutant is None)

    page = open_served(f"lite/notebooks/index.html?path={notebook.name}.ipynb")
    cells = {f"%%node {name}": f"%%node {name}\n{text}" for name, text in files.items()}
    said = said_at_the_end(page, {**cells, "": SAYS.format(exercise.slug)})

    measured = "callback_time"  # by the wall clock
    found = [each for each in json.loads(said) if each[0] != measured]
    assert found == [[c.id, c.outcome, c.message] for c in graded.checks if c.id != measured]
    assert page.locator(".jp-OutputArea-output iframe").count() > 0  # replays


UNTIL = """new Promise((tell) => { const look = () => {
  const is = globalThis.jupyterapp && %s;
  if (is) tell(is); else setTimeout(look, 50);
}; look(); })"""
LOADING = "document.querySelector('#course-loading')?.textContent.match(/loading: \\d+ of \\d+ MB/)"
OPEN = """document.querySelector('.jp-Notebook .jp-Cell')
  && jupyterapp.shell.currentWidget?.sessionContext.isReady"""
FIRST = """(({ content }) => {
  content.activeCellIndex = content.widgets.findIndex(({ model }) => model.type === 'code');
  void jupyterapp.commands.execute('notebook:run-cell');
})(jupyterapp.shell.currentWidget)"""
PRINTED = f"({OUTPUTS})().at(%s).flatMap(({{ text }}) => text ?? '').join('').match(%s)"
STORED = "caches.open('course-notebooks').then((store) => store.match(location.href)).then(Boolean)"


@pytest.mark.parametrize("name", ["chromium", "firefox"])
def test_it_says_how_far_it_is_and_a_second_visit_needs_no_network(
    name: str, site: Path, tmp_path: Path
) -> None:
    exercise = find_exercise("1")
    (file,) = exercise.files
    reference = f"%%node {file}\n{(exercise.solutions / file).read_text('utf-8')}"
    texts = {f"%%node {file}": reference, "": SAYS.format(exercise.slug)}
    with BROWSERS[name](tmp_path / "own") as tab:
        with served(site, tmp_path / "served") as address:
            page = f"{address}/lite/notebooks/index.html?path=01_loop.ipynb"
            tab.open(page)
            tab.value(UNTIL % LOADING)
            tab.value(UNTIL % OPEN)
            tab.value(FIRST)
            for words in (r"/loading: part \d of 3/", "/Ready: /"):
                tab.value(UNTIL % PRINTED % (0, words))
            while not tab.value(STORED):
                pass
        tab.open(page)  # its server has ended
        tab.value(UNTIL % OPEN)
        tab.value(f"({RUN})({json.dumps(texts)})")
        _, said = tab.value(UNTIL % PRINTED % (-1, "/SAID (.*)/"))
    outcomes = {check: outcome for check, outcome, _ in json.loads(said)}
    assert outcomes.pop("callback_time") in ("pass", "inconclusive")
    assert set(outcomes.values()) == {"pass"}
