"""The workspace in a real browser: the built site, from a plain server, below a sub-path.

Every other host leads nowhere. What is typed is driven and checked by the page; the verdicts are
those of `course grade`. Without `make workspace` these tests are skipped.
"""

from __future__ import annotations

import functools
import http.server
import shutil
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from grader.authoring.mutants import find_mutant
from grader.course.exercises import ROOT, find_exercise
from grader.course.submission import find_submission
from grader.grading.grading import grade_submission
from grader.link.hosts import ForkServer

MADE = ROOT / "build" / "workspace" / "manifest.json"
ARGUMENTS = ["--no-sandbox", "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"]
SLOW = 1_200_000  # [ms] for all of a busy machine's trials
TYPED = [
    ("obstacle_avoidance", None),
    ("obstacle_avoidance", "narrow_cone"),
    ("trend_memory", None),
]
MEASURED = ("callback_time",)  # by the wall clock: a busy machine shows in it
DRIVE_ON = "import time\n\nwhile True:\n    pass\n"

pytestmark = pytest.mark.skipif(
    not MADE.is_file(), reason="the site has no workspace here: run `make workspace`"
)


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: object) -> None:
        pass


@pytest.fixture(scope="module")
def address(site: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Where a plain server has the site, below a sub-path."""
    root = tmp_path_factory.mktemp("served")
    (root / "below" / "it").mkdir(parents=True)
    (root / "below" / "it" / "course").symlink_to(site)
    handler = functools.partial(Quiet, directory=str(root))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/below/it/course"
        server.shutdown()


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    path = shutil.which("chromium")
    if path is None:
        pytest.skip("no browser: chromium is not on the PATH")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.fixture
def open_workspace(chromium: Any, address: str) -> Iterator[Any]:
    """Open an exercise's workspace; at the end no other host was asked for anything."""
    asked: list[str] = []
    contexts = []

    def open_(slug: str, **options: Any) -> Any:
        context = chromium.new_context(viewport={"width": 1280, "height": 800}, **options)
        contexts.append(context)
        page = context.new_page()
        page.on("request", lambda request: asked.append(request.url))
        page.goto(f"{address}/exercises/{slug}/README.html")
        enter(page)
        return page

    yield open_
    for context in contexts:
        context.close()
    ours = (address, "blob:", "data:", "about:")
    assert [url for url in asked if not url.startswith(ours)] == []


def enter(page: Any) -> None:
    page.get_by_role("button", name="Open the workspace").click()
    page.locator(".cm-content").wait_for()


def type_in(page: Any, text: str) -> None:
    page.locator(".cm-content").click()
    page.keyboard.press("Control+A")
    page.keyboard.insert_text(text)


def settle(page: Any) -> str:
    """Wait until nothing is under way; return what the page says of it."""
    page.locator("dialog.workspace[aria-busy=false]").wait_for(timeout=SLOW)
    return str(page.locator(".ws-status").inner_text())


@pytest.mark.parametrize(("slug", "mutant"), TYPED)
def test_a_node_that_is_typed_in_gets_the_verdicts_of_course_grade(
    open_workspace: Any, forkserver: ForkServer, tmp_path: Path, slug: str, mutant: str | None
) -> None:
    exercise = find_exercise(slug)
    file = tmp_path / exercise.files[0]
    reference = exercise.solutions / exercise.files[0]
    file.write_text(find_mutant(exercise, mutant).text if mutant else reference.read_text("utf-8"))
    expected = grade_submission(exercise, find_submission(file), forkserver, file=file.name)
    page = open_workspace(slug)
    settle(page)
    type_in(page, file.read_text("utf-8"))
    page.get_by_role("button", name="Check").click()
    said = settle(page)
    rows = page.locator(".ws-list li").evaluate_all(
        "(all) => all.map((row) => [row.dataset.check, row.dataset.outcome,"
        " row.querySelector('.ws-detail p')?.textContent || ''])"
    )
    found = {name: (outcome, text) for name, outcome, text in rows if name not in MEASURED}
    wanted = {c.id: (c.outcome, c.message) for c in expected.checks if c.id not in MEASURED}
    assert found == wanted
    assert "points" in said
    replay = page.frame_locator(".ws-replay iframe")
    assert replay.locator("canvas").count() > 0


def test_what_was_typed_survives_a_reload_and_a_stop(open_workspace: Any) -> None:
    page = open_workspace("obstacle_avoidance")
    settle(page)
    type_in(page, DRIVE_ON)
    page.get_by_role("button", name="Drive").click()
    page.get_by_role("button", name="Stop it").wait_for(timeout=SLOW)
    page.get_by_role("button", name="Stop it").click()
    assert settle(page) == "Stopped."
    page.reload()
    enter(page)
    assert "while True" in page.locator(".cm-content").inner_text()
