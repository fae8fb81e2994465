"""What the page costs in Chromium: its weight, a first check, a check and a drive once it is warm.

    python benchmarks/page.py [EXERCISE]

It needs `make workspace` and `make site`. `course grade` runs beside it, warm, in the same run: the
figures of a busy machine are good for ratios only, and CPU times.
"""

import functools
import gzip
import http.server
import json
import os
import shutil
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from grader.course.exercises import ROOT, find_exercise
from grader.course.submission import find_submission
from grader.grading.grading import grade_submission
from grader.launchers import fork_server

SITE = ROOT / "build" / "site"
MADE = SITE / "_static" / "workspace"
COMPRESSED = (".pack",)  # already; the rest is counted as servers send it that compress
TICK = os.sysconf("SC_CLK_TCK")  # [1/s]
SLOW = 1_200_000  # [ms]


class _Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: object) -> None:
        pass


def main() -> int:
    """Print the figures."""
    exercise = find_exercise(sys.argv[1] if sys.argv[1:] else "1")
    if not (MADE / "manifest.json").is_file():
        print(f"{MADE}: expected the workspace; run `make workspace` and `make site`")
        return 1
    _weigh()
    file = exercise.solutions / exercise.files[0]
    handler = functools.partial(_Quiet, directory=str(SITE))
    with (
        http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server,
        sync_playwright() as playwright,
    ):
        threading.Thread(target=server.serve_forever, daemon=True).start()
        chromium = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox"]
        )
        page = chromium.new_page(viewport={"width": 1280, "height": 800})
        page.goto(f"http://127.0.0.1:{server.server_port}/exercises/{exercise.slug}/README.html")
        _measure("ready, from nothing", lambda: _open(page))
        page.locator(".cm-content").click()
        page.keyboard.press("Control+A")
        page.keyboard.insert_text(file.read_text("utf-8"))
        for name, keys in (("first check", "Control+Shift+Enter"), ("check", "Control+Shift+Enter"),
                           ("drive and replay", "Control+Enter")):  # fmt: skip
            _measure(name, functools.partial(_do, page, keys))
        chromium.close()
        server.shutdown()
    with fork_server() as forkserver, tempfile.TemporaryDirectory() as name:
        node = find_submission(Path(shutil.copy(file, name)))
        for said in ("course grade, first", "course grade, warm"):
            _measure(said, lambda: grade_submission(exercise, node, forkserver, file=file.name))
    print(f"load average {os.getloadavg()[0]:.1f} on {os.cpu_count()} CPUs")
    return 0


def _weigh() -> None:
    total = 0
    for name in json.loads((MADE / "manifest.json").read_text("utf-8")):
        content = (MADE / name).read_bytes()
        size = len(content if name.endswith(COMPRESSED) else gzip.compress(content))
        total += size
        print(f"{size / 1e6:8.2f} MB  {name}")
    print(f"{total / 1e6:8.2f} MB  first visit, compressed")


def _open(page: Page) -> None:
    page.get_by_role("button", name="Open the workspace").click()
    page.locator(".ws-status", has_text="Ready.").wait_for(timeout=SLOW)


def _do(page: Page, keys: str) -> None:
    page.keyboard.press(keys)
    page.locator("dialog.workspace[aria-busy=true]").wait_for()
    page.locator("dialog.workspace[aria-busy=false]").wait_for(timeout=SLOW)


def _measure(name: str, work: Callable[[], object]) -> None:
    cpu, wall = _cpu(), time.perf_counter()
    work()
    wall = time.perf_counter() - wall
    print(f"{wall:8.1f} s  {name}; {_cpu() - cpu:.1f} s of CPU", flush=True)


def _cpu() -> float:
    """Return the CPU time of this process and its descendants, Chromium among them [s]."""
    return sum(_spent(pid) for pid in _family(os.getpid()))


def _family(pid: int) -> Iterator[int]:
    yield pid
    for children in Path(f"/proc/{pid}/task").glob("*/children"):
        try:
            found = children.read_text().split()
        except OSError:  # it has just ended
            continue
        for child in found:
            yield from _family(int(child))


def _spent(pid: int) -> float:
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return sum(map(int, fields[11:15])) / TICK  # its own, and its dead children's


if __name__ == "__main__":
    sys.exit(main())
