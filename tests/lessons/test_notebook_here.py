"""Notebooks in the site: those of exercises that are left out do not get there."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import notebook_here
import pytest

NODES = {"01_loop": "obstacle_avoidance_agent.py", "03_goal": "goal_seeking_agent.py"}


@pytest.fixture
def app(tmp_path: Path) -> Any:
    made = tmp_path / "lite"
    index = made / "api" / "contents" / "all.json"
    for folder in (made / "files", index.parent):
        folder.mkdir(parents=True)
    for name, file in NODES.items():
        cells = [{"source": [f"%%node {file}\n", "x = 1"]}]
        (made / "files" / f"{name}.ipynb").write_text(json.dumps({"cells": cells}))
    index.write_text(json.dumps({"content": [{"name": f"{name}.ipynb"} for name in NODES]}))
    config = SimpleNamespace(course_lite=str(made), course_lite_made=True, course_left_out="")
    return SimpleNamespace(config=config, outdir=str(tmp_path / "site"))


@pytest.mark.parametrize(("slug", "linked"), [("goal_seeking", True), ("slow_model", False)])
def test_a_notebook_is_linked_from_its_exercise(app: Any, slug: str, linked: bool) -> None:
    page = {"body": "<h1>Goal</h1><p>…</p>"}
    notebook_here.add_link(app, f"exercises/{slug}/README", "", page, None)
    assert ("lite/notebooks/index.html?path=03_goal.ipynb" in page["body"]) == linked


def test_the_notebook_of_an_exercise_that_is_left_out_stays_out(app: Any) -> None:
    app.config.course_left_out = "goal_seeking"
    notebook_here.copy_files(app, None)
    lite = Path(app.outdir, "lite")
    assert [path.name for path in (lite / "files").iterdir()] == ["01_loop.ipynb"]
    index = json.loads((lite / "api" / "contents" / "all.json").read_text())
    assert [each["name"] for each in index["content"]] == ["01_loop.ipynb"]
