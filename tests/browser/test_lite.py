"""The notebooks in JupyterLite, in a real browser: the built site, every other host leads nowhere.

The cells are those that students get; what is written into them is driven by the page's runtime and
judged in the notebook's kernel. Without `make lite` these tests are skipped.
"""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import pytest
from served_site import SLOW

from grader.authoring.mutants import find_mutant
from grader.course.exercises import ROOT, find_exercise
from grader.course.submission import find_submission
from grader.grading.grading import grade_submission
from grader.link.hosts import ForkServer

MADE = ROOT / "build" / "lite" / "index.html"
NOTEBOOKS = {  # and their exercises
    "01_loop": "obstacle_avoidance",
    "03_goal": "goal_seeking",
    "04_memory": "trend_memory",
    "05_real_time": "slow_model",
    "06_model_server": "model_server",
    "07_supervisor": "safety_supervisor",
    "09_latency": "latency_monitor",
    "10_live_parameters": "live_parameters",
    "11_three_nodes": "three_nodes",
}
MUTANTS = {"01_loop": "narrow_cone", "03_goal": "yaw_in_degrees", "04_memory": "whole_circle"}
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


@pytest.mark.parametrize(
    ("notebook", "mutant"), [*((name, None) for name in NOTEBOOKS), *MUTANTS.items()]
)
def test_a_notebook_runs_in_the_browser_and_judges_as_course_grade(
    open_served: Any, forkserver: ForkServer, tmp_path: Path, notebook: str, mutant: str | None
) -> None:
    exercise = find_exercise(NOTEBOOKS[notebook])
    files = {name: (exercise.solutions / name).read_text() for name in exercise.files}
    if mutant:
        files[exercise.files[0]] = find_mutant(exercise, mutant).text
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    submission = find_submission(tmp_path / exercise.files[0], others=exercise.files[1:])
    graded = grade_submission(exercise, submission, forkserver, file=exercise.files[0])
    assert (graded.score == 100) == (mutant is None)

    page = open_served(f"lite/notebooks/index.html?path={notebook}.ipynb")
    cells = {f"%%node {name}": f"%%node {name}\n{text}" for name, text in files.items()}
    said = said_at_the_end(page, {**cells, "": SAYS.format(exercise.slug)})

    measured = "callback_time"  # by the wall clock
    found = [each for each in json.loads(said) if each[0] != measured]
    assert found == [[c.id, c.outcome, c.message] for c in graded.checks if c.id != measured]
    assert page.locator(".jp-OutputArea-output iframe").count() > 0  # replays
