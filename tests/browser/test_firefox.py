"""The workspace in a real Firefox, by WebDriver BiDi: skipped where there is none.

The page comes as in Chromium's tests. A link carries the node, since nobody types here.
"""

from __future__ import annotations

import base64
import itertools
import json
import os
import re
import shutil
import subprocess
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from grader.claims.mutants import find_mutant
from grader.course.exercises import ROOT, find_exercise
from grader.course.submission import find_submission
from grader.grading.grading import grade_submission
from rclpy_virtual_time.link.hosts import ForkServer

MEASURED = ("callback_time",)  # by the wall clock: a busy machine shows in it
SETTLED = """new Promise((tell) => { const look = () => {
  const dialog = document.querySelector('dialog.workspace:not([aria-busy=true])');
  const said = dialog?.querySelector('.ws-status').innerText;
  if (said) tell(said); else setTimeout(look, 50);
}; look(); })"""
CHECK = "[...document.querySelectorAll('.ws-main')].find((b) => b.innerText === 'Check').click()"
FOUND = """JSON.stringify([...document.querySelectorAll('.ws-list li')].map((row) =>
  [row.dataset.check,
    [row.dataset.outcome, row.querySelector('.ws-detail p')?.textContent || '']]))"""

pytestmark = pytest.mark.skipif(
    not (ROOT / "build" / "workspace" / "manifest.json").is_file(),
    reason="the site has no workspace here: run `make workspace`",
)


@pytest.fixture
def firefox(tmp_path: Path) -> Iterator[Callable[..., Any]]:
    """Do what a command of BiDi says, in the one tab."""
    websocket = pytest.importorskip("websocket", reason="websocket-client is not installed")
    path = shutil.which("firefox-esr") or shutil.which("firefox")
    if path is None:
        pytest.skip("no browser: firefox is not on the PATH")
    (profile := tmp_path / "profile").mkdir()
    command = [path, "--headless", "--no-remote", "--profile", str(profile)]
    with subprocess.Popen(
        [*command, "--remote-debugging-port=0"],
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "HOME": str(profile), "MOZ_DISABLE_CONTENT_SANDBOX": "1"},
    ) as process:
        try:
            assert process.stderr is not None
            said = (re.search(r"listening on (ws://\S+)", line) for line in process.stderr)
            place = next(filter(None, said))[1]
            link = websocket.create_connection(
                f"{place}/session", timeout=600, suppress_origin=True
            )
            numbers = itertools.count(1)

            def ask(method: str, **parameters: Any) -> Any:
                number = next(numbers)
                link.send(json.dumps({"id": number, "method": method, "params": parameters}))
                answer = next(a for a in iter(lambda: json.loads(link.recv()), None)
                              if a.get("id") == number)  # fmt: skip
                assert answer["type"] == "success", answer
                return answer["result"]

            ask("session.new", capabilities={})
            yield ask
            link.close()
        finally:
            process.terminate()


@pytest.fixture
def value(firefox: Callable[..., Any], address: str) -> Callable[..., Any]:
    """Open an exercise's workspace with a node, or evaluate a script there."""
    tab = firefox("browsingContext.getTree")["contexts"][0]["context"]

    def value_(script: str = "", slug: str = "", node: bytes = b"") -> Any:
        if slug:
            code = base64.urlsafe_b64encode(zlib.compress(node)).decode().rstrip("=")
            url = f"{address}/exercises/{slug}/README.html#code={code}"
            firefox("browsingContext.navigate", context=tab, url=url, wait="complete")
            script = SETTLED
        told = firefox(
            "script.evaluate", expression=script, target={"context": tab}, awaitPromise=True
        )
        assert told["type"] == "success", told
        return told["result"].get("value")

    return value_


@pytest.mark.parametrize(
    ("slug", "mutant"),
    [("obstacle_avoidance", None), ("obstacle_avoidance", "narrow_cone"), ("trend_memory", None)],
)
def test_firefox_judges_as_course_grade_does(
    value: Callable[..., Any],
    forkserver: ForkServer,
    tmp_path: Path,
    slug: str,
    mutant: str | None,
) -> None:
    exercise = find_exercise(slug)
    (file := tmp_path / "node" / exercise.files[0]).parent.mkdir()
    reference = exercise.solutions / file.name
    file.write_text(find_mutant(exercise, mutant).text if mutant else reference.read_text())
    graded = grade_submission(exercise, find_submission(file), forkserver, file=file.name)

    assert value(slug=slug, node=file.read_bytes()).startswith("Ready.")
    value(CHECK)
    assert value(SETTLED) == f"{graded.as_dict()['score']} of {exercise.max_points} points."
    wanted = {c.id: [c.outcome, c.message] for c in graded.checks if c.id not in MEASURED}
    found = dict(json.loads(value(FOUND)))
    assert {name: said for name, said in found.items() if name not in MEASURED} == wanted


def test_firefox_is_told_where_threads_are_needed(value: Callable[..., Any]) -> None:
    assert "needs threads, which only some browsers have" in value(slug="latency_monitor")
