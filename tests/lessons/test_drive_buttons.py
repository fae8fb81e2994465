"""Which of the pages' programs get a button that lets them drive in the browser."""

import html.parser
import json
from pathlib import Path
from typing import Any

import pytest
from drive_here import needs_threads, runs_there
from lesson_pages import LESSONS, PAGES, ROOT, blocks

HERE = {"modules": ["math", "rclpy", "threading"], "scenarios": ["demo_wall"], "refused": ["--bag"]}
WALL = ["--scenario", "demo_wall"]
MADE = ROOT / "build" / "workspace" / "manifest.json"
KEPT_BACK = {  # commands of the pages without a button, and why
    "bags": "it writes a bag",
    "launch_files": "a launch file starts programs that are not on the page",
    "models": "a model in a file, and scikit-learn",
    "why": "the skeleton of exercise 1, which no page shows",
}


@pytest.mark.parametrize(
    ("text", "words", "runs"),
    [
        ("import math\nfrom rclpy.node import Node\n", WALL, True),
        ("import threading\n", [*WALL, "--param", "a:=1"], True),
        ("def late():\n    import sklearn.tree\n", WALL, False),
        ("from pickle import load\n", WALL, False),
        ("import rclpy, launch\n", WALL, False),
        ("import math\n", ["--scenario", "ml_drive_store"], False),
        ("import math\n", [*WALL, "--bag", "wall"], False),
        ("import math\n", [*WALL, "--bag=wall"], False),
        ("import math\n", [], False),
    ],
)
def test_a_program_runs_there_by_what_it_imports_and_where_it_drives(
    text: str, words: list[str], runs: bool
) -> None:
    assert runs_there(text, words, HERE) == runs


@pytest.mark.parametrize(
    ("text", "threads"),
    [
        ("import rclpy\n", False),
        ("from rclpy.executors import SingleThreadedExecutor\n", False),
        ("from rclpy.executors import MultiThreadedExecutor\n", True),
        ("import threading\n", True),
        ("from concurrent.futures import ThreadPoolExecutor\n", True),
    ],
)
def test_threads_are_known_by_imports(text: str, threads: bool) -> None:
    assert needs_threads(text) == threads


class Places(html.parser.HTMLParser):
    """The places of a page's buttons."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.found: list[dict[str, Any]] = []
        self.feed(file.read_text("utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if ("class", "drive-here") in attrs:
            self.found.append(dict(attrs))


@pytest.mark.skipif(not MADE.is_file(), reason="the site has no workspace: run `make workspace`")
def test_every_command_has_its_button_unless_it_can_t_run_there(site: Path) -> None:
    for page in PAGES:
        shown = [b.text for b in blocks(page) if b.text.startswith("$ course drive ")]
        commands = [" ".join(text.replace("\\\n", " ").split()[3:]) for text in shown]
        found = Places(site / f"{page.stem}.html").found
        said = [f"{place['data-file']} {place['data-arguments']}" for place in found]
        if page.stem in KEPT_BACK:
            assert said == [], page.stem
            continue
        assert said == commands, page.stem


@pytest.mark.skipif(not MADE.is_file(), reason="the site has no workspace: run `make workspace`")
def test_a_button_carries_the_listing_as_it_is(site: Path) -> None:
    listed = {
        (page.stem, block.options["caption"]): block.text
        for page in PAGES for block in blocks(page) if "caption" in block.options
    }  # fmt: skip
    for page in PAGES:
        for place in Places(site / f"{page.stem}.html").found:
            assert place["data-code"] == listed[place["data-page"], place["data-file"]]
    threads = [place["data-file"] for place in Places(site / "real_time.html").found
               if "data-threads" in place]  # fmt: skip
    assert threads == ["beat.py"] * 5
    assert all("data-threads" in place for place in Places(site / "parameters.html").found)


@pytest.mark.skipif(not MADE.is_file(), reason="the site has no workspace: run `make workspace`")
def test_a_pitfall_s_node_is_mended_where_its_scenario_can_be_had(site: Path) -> None:
    known = json.loads((MADE.parent / "plan.json").read_text("utf-8"))["drives"]["scenarios"]
    for file in (site / "pitfalls").glob("*.html"):
        for place in Places(file).found:
            node = LESSONS / "pitfalls" / "nodes" / place["data-file"]
            assert place["data-code"] == node.read_text("utf-8")
            assert place["data-arguments"].split()[1] in known
    assert len(Places(site / "pitfalls" / "front_by_index.html").found) == 1
    assert Places(site / "pitfalls" / "nan_through_clip.html").found == []  # a pickled model
