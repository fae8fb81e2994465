"""A block on exercises' pages that opens their workspace, if the site is built with it.

`make workspace` makes its files (workspace/build.py); without them there is no block. The list of
exercises says what of each runs in the reader's browser.
"""

from __future__ import annotations

import html
import json
import re
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx
    from sphinx.config import Config

ROOT = Path(__file__).resolve().parents[2]
MADE = ROOT / "build" / "workspace"
STATIC = "_static/workspace"
WAYS = ROOT / "build" / "ways"  # of others, for after full marks: `make ways`
WORDS = (
    '<p class="workspace-words">The workspace is loading …</p>'
    "<noscript><p>The workspace is not running: it needs JavaScript.</p></noscript>"
)
LISTED = re.compile(r'<a class="reference internal" href="(\w+)/README.html">.*?</a>')


def add_block(app: Sphinx, name: str, _template: str, page: dict[str, Any], _tree: object) -> None:
    """Put the block below the heading of an exercise's page; let the front page lead there."""
    if not app.config.course_workspace_made:
        return
    if name == "index":
        start = 'href="exercises/obstacle_avoidance/README.html"'
        page["body"] = page["body"].replace(start, f'{start[:-1]}#workspace"', 1)
        return
    if name == "exercises/index":
        plan = json.loads(Path(app.config.course_workspace, "plan.json").read_text("utf-8"))
        page["body"] = LISTED.sub(lambda row: row[0] + _here(plan, row[1]), page["body"])
        _add_script(app)
        return
    parts = name.split("/")
    if parts[0] != "exercises" or parts[-1] != "README" or parts[1] in _left_out(app):
        return
    block = (
        f'<div class="workspace-block" id="workspace" data-exercise="{html.escape(parts[1])}">'
        f'{WORDS}<p class="workspace-open"></p></div>'
    )
    page["body"] = page["body"].replace("</h1>", f"</h1>{block}", 1)
    _add_script(app)


def _here(plan: dict[str, Any], slug: str) -> str:
    """Return the place below an exercise's link; the browser fills it (workspace/web/able.js)."""
    numbers = " ".join(
        f'data-{key}="{plan["exercises"][slug][key]}"' for key in ("points", "here", "alone")
    )
    return f'<small class="runs-here" {numbers}></small>'


def _add_script(app: Sphinx) -> None:
    app.add_css_file("workspace/workspace.css")
    app.add_js_file("workspace/start.js", loading_method="defer")


def _left_out(app: Sphinx) -> list[str]:
    found: list[str] = app.config.course_left_out.split(",")
    return found


def _made(config: Config) -> bool:
    return bool(config.course_workspace) and Path(config.course_workspace).is_dir()


def copy_files(app: Sphinx, error: Exception | None) -> None:
    """Lay the files beside the site's own."""
    if error is None and app.config.course_workspace_made:
        source = Path(app.config.course_workspace)
        target = Path(shutil.copytree(source, Path(app.outdir, STATIC), dirs_exist_ok=True))
        shutil.copy(target / "offline.js", app.outdir)  # its reach is its folder
        plans = json.loads((target / "plan.json").read_text("utf-8"))
        for slug in _left_out(app):  # no skeleton of one that is
            plans["exercises"].pop(slug, None)
        shutil.rmtree(target.parent / "ways", ignore_errors=True)
        for slug, about in plans["exercises"].items():
            way = Path(app.config.course_ways, f"{slug}.json")
            about["ways"] = bool(app.config.course_ways) and way.is_file()
            if about["ways"]:
                (target.parent / "ways").mkdir(exist_ok=True)
                shutil.copy(way, target.parent / "ways")
        (target / "plan.json").write_text(json.dumps(plans, separators=(",", ":")), "utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Tell Sphinx."""
    app.add_config_value("course_workspace", str(MADE), "env", [str])  # a folder; "" for none
    app.add_config_value("course_workspace_made", _made, "html", [bool])  # pages follow it
    app.add_config_value("course_ways", str(WAYS), "html", [str])  # "": none, whatever lies there
    app.connect("html-page-context", add_block)
    app.connect("build-finished", copy_files)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
