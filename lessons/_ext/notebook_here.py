"""A link on exercises' pages to their notebook in the browser, if the site is built with them.

`make lite` makes the files (workspace/lite.py). They need those of `make workspace`, too.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx
    from sphinx.config import Config

ROOT = Path(__file__).resolve().parents[2]
MADE = ROOT / "build" / "lite"
LINK = (
    '<p class="notebook-here">Or <a href="../../lite/notebooks/index.html?path={}">in a notebook'
    "</a>, which runs in this browser, too. Its first start fetches 50 MB.</p>"
)


def add_link(app: Sphinx, name: str, _template: str, page: dict[str, Any], _tree: object) -> None:
    """Put the link below the heading of an exercise's page."""
    parts = name.split("/")
    if app.config.course_lite_made and parts[0] == "exercises" and parts[-1] == "README":
        for notebook, text in _notebooks(app).items():
            if f'"%%node {_file(parts[1])}' in text:
                link = f"</h1>{LINK.format(notebook)}"
                page["body"] = page["body"].replace("</h1>", link, 1)


def copy_files(app: Sphinx, error: Exception | None) -> None:
    """Lay JupyterLite beside the site's pages, without the notebooks of what is left out."""
    if error is not None or not app.config.course_lite_made:
        return
    target = Path(app.outdir, "lite")
    shutil.rmtree(target, ignore_errors=True)
    shutil.copytree(app.config.course_lite, target)
    index = target / "api" / "contents" / "all.json"
    contents, known = json.loads(index.read_text("utf-8")), _notebooks(app)
    contents["content"] = [each for each in contents["content"] if each["name"] in known]
    index.write_text(json.dumps(contents), "utf-8")
    for path in (target / "files").iterdir():
        if path.name not in known:
            path.unlink()


def _notebooks(app: Sphinx) -> dict[str, str]:
    """Return the notebooks' texts by their names, without those of exercises that are left out."""
    left_out = filter(None, app.config.course_left_out.split(","))
    gone = [f'"%%node {_file(slug)}' for slug in left_out]
    files = sorted(Path(app.config.course_lite, "files").glob("*.ipynb"))
    texts = {file.name: file.read_text("utf-8") for file in files}
    return {name: text for name, text in texts.items() if not any(cell in text for cell in gone)}


def _file(slug: str) -> str:
    from grader.course.exercises import find_exercise  # noqa: PLC0415

    return find_exercise(slug).files[0]


def _made(config: Config) -> bool:
    folders = config.course_lite, config.course_workspace
    return all(folder and Path(folder).is_dir() for folder in folders)


def setup(app: Sphinx) -> dict[str, Any]:
    """Tell Sphinx."""
    app.add_config_value("course_lite", str(MADE), "env", [str])  # a folder; "" for none
    app.add_config_value("course_lite_made", _made, "html", [bool])  # pages follow it
    app.connect("html-page-context", add_link)
    app.connect("build-finished", copy_files)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
