"""Links on exercises' pages to their notebooks: in the browser, and where the instructor says.

`make lite` makes the files of the first (workspace/lite.py). They need those of `make workspace`.
"""

from __future__ import annotations

import html
import json
import shutil
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx
    from sphinx.config import Config

ROOT = Path(__file__).resolve().parents[2]
MADE = ROOT / "build" / "lite"
HERE = (
    '<p class="notebook">Or <a href="../../lite/notebooks/index.html?path={}">in a notebook</a>, '
    "which runs in this browser, too. Its first start fetches 50 MB.</p>"
)
COLAB = '<p class="notebook"><a href="{}/{}">Open its notebook in Colab</a></p>'


def add_links(app: Sphinx, name: str, _template: str, page: dict[str, Any], _tree: object) -> None:
    """Put the links below the heading of an exercise's page."""
    folder, _, rest = name.partition("/")
    slug, config = rest.removesuffix("/README"), app.config
    if folder != "exercises" or slug == rest or slug in config.course_left_out.split(","):
        return
    notebook, links = _notebook(slug), ""
    if config.course_lite_made and Path(config.course_lite, "files", notebook).is_file():
        links += HERE.format(notebook)
    if config.course_colab:
        links += COLAB.format(html.escape(config.course_colab.rstrip("/")), notebook)
    page["body"] = page["body"].replace("</h1>", f"</h1>{links}", 1)


def copy_files(app: Sphinx, error: Exception | None) -> None:
    """Lay JupyterLite beside the site's pages, without the notebooks of what is left out."""
    if error is not None or not app.config.course_lite_made:
        return
    target = Path(app.outdir, "lite")
    shutil.rmtree(target, ignore_errors=True)
    shutil.copytree(app.config.course_lite, target)
    gone = {_notebook(slug) for slug in filter(None, app.config.course_left_out.split(","))}
    index = target / "api" / "contents" / "all.json"
    contents = json.loads(index.read_text("utf-8"))
    contents["content"] = [each for each in contents["content"] if each["name"] not in gone]
    index.write_text(json.dumps(contents), "utf-8")
    for notebook in gone:
        (target / "files" / notebook).unlink(missing_ok=True)


def _notebook(slug: str) -> str:
    about = tomllib.loads((ROOT / "exercises" / slug / "exercise.toml").read_text("utf-8"))
    (folder,) = (ROOT / "notebooks" / "text").glob(f"{about['number']:02}_*")
    return f"{folder.name}.ipynb"


def _made(config: Config) -> bool:
    folders = config.course_lite, config.course_workspace
    return all(folder and Path(folder).is_dir() for folder in folders)


def setup(app: Sphinx) -> dict[str, Any]:
    """Tell Sphinx."""
    app.add_config_value("course_lite", str(MADE), "env", [str])  # a folder; "" for none
    app.add_config_value("course_lite_made", _made, "html", [bool])  # pages follow it
    app.add_config_value("course_colab", "", "html", [str])  # where the released notebooks lie
    app.connect("html-page-context", add_links)
    app.connect("build-finished", copy_files)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
