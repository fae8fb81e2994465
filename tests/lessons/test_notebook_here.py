"""Links to notebooks, and that those of exercises that are left out do not get into the site."""

import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import notebook_here
import pytest

NOTEBOOKS = ["01_loop.ipynb", "03_goal.ipynb"]


@pytest.fixture
def app(tmp_path: Path) -> Any:
    made = tmp_path / "lite"
    index = made / "api" / "contents" / "all.json"
    for folder in (made / "files", index.parent):
        folder.mkdir(parents=True)
    for name in NOTEBOOKS:
        (made / "files" / name).touch()
    index.write_text(json.dumps({"content": [{"name": name} for name in NOTEBOOKS]}))
    config = SimpleNamespace(
        course_lite=str(made), course_lite_made=True, course_left_out="", course_colab=""
    )
    return SimpleNamespace(config=config, outdir=str(tmp_path / "site"))


@pytest.mark.parametrize(
    ("page", "left_out", "colab", "linked"),
    [
        ("goal_seeking/README", "", "", ["../../lite/notebooks/index.html?path=03_goal"]),
        ("slow_model/README", "", "", []),
        ("slow_model/README", "", "https://h/o/r/", ["https://h/o/r/05_real_time"]),
        ("live_parameters/README", "", "https://h", ["https://h/10_live_parameters"]),
        ("goal_seeking/README", "model_server,goal_seeking", "https://h", []),
        ("goal_seeking/hints", "", "https://h", []),
        ("index", "", "https://h", []),
    ],
)
def test_an_exercise_links_its_notebook_wherever_that_is(
    app: Any, page: str, left_out: str, colab: str, linked: list[str]
) -> None:
    app.config.course_left_out, app.config.course_colab = left_out, colab
    shown = {"body": "<h1>Goal</h1><p>…</p>"}
    notebook_here.add_links(app, f"exercises/{page}", "", shown, None)
    assert re.findall(r'href="(.+?)\.ipynb"', shown["body"]) == linked


def test_the_notebook_of_an_exercise_that_is_left_out_stays_out(app: Any) -> None:
    app.config.course_left_out = "goal_seeking"
    notebook_here.copy_files(app, None)
    lite = Path(app.outdir, "lite")
    assert [path.name for path in (lite / "files").iterdir()] == ["01_loop.ipynb"]
    index = json.loads((lite / "api" / "contents" / "all.json").read_text())
    assert [each["name"] for each in index["content"]] == ["01_loop.ipynb"]
