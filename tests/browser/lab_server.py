"""A Jupyter server of our own in a temporary folder, and pages of it in a browser."""

import json
import os
import secrets
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from frames import LIMIT

from grader.course.exercises import ROOT

NOTEBOOK_TESTS = str(ROOT / "tests" / "notebooks")
sys.path[:0] = [path for path in [NOTEBOOK_TESTS] if path not in sys.path]  # nbgrader_kit
IMAGES = ROOT / "docs" / "images"
SETTINGS = {
    # nobody asks whether there is news, and no question stands before what is to be seen
    "@jupyterlab/apputils-extension:notification": {
        "fetchNews": "false", "checkForUpdates": False, "doNotDisturbMode": True,
    },
    "@jupyterlab/lsp-extension:plugin": {"activate": "off"},
}  # fmt: skip


@dataclass(frozen=True)
class Server:
    """A server that answers."""

    folder: Path
    url: str  # ends in /
    token: str

    def address(self, path: str) -> str:
        """Where a page is, with the token."""
        return f"{self.url}{path}?token={self.token}"

    def ask(self, path: str) -> Any:
        """What the server's API says."""
        with urllib.request.urlopen(self.address(path), timeout=LIMIT) as answer:
            return json.load(answer)


@contextmanager
def serving(folder: Path, place: Path, **variables: str) -> Iterator[Server]:
    """Serve a folder with JupyterLab; all that Jupyter keeps for itself goes to `place`."""
    token = secrets.token_hex(16)
    overrides = place / "settings" / "overrides.json"
    overrides.parent.mkdir(parents=True)
    overrides.write_text(json.dumps(SETTINGS), "utf-8")
    homes = {name: str(place / name.lower()) for name in (
        "JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR", "IPYTHONDIR",
        "JUPYTERLAB_SETTINGS_DIR", "JUPYTERLAB_WORKSPACES_DIR", "MPLCONFIGDIR",
    )}  # fmt: skip
    command = [
        sys.executable, "-m", "jupyterlab", "--no-browser", "--allow-root", "--ip=127.0.0.1",
        "--port=0", f"--ServerApp.root_dir={folder}",
        f"--LabApp.app_settings_dir={place}/settings",
        "--LabApp.expose_app_in_browser=True", "--LabApp.news_url=None",
        "--LabApp.extension_manager=readonly",
        "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate",
    ]  # fmt: skip
    log = place / "server.log"
    with log.open("wb") as out:
        process = subprocess.Popen(
            command, cwd=folder, stdout=out, stderr=out, stdin=subprocess.DEVNULL,
            env={**os.environ, **homes, "JUPYTER_TOKEN": token, **variables},
        )  # fmt: skip
        try:
            url = _url(process, Path(homes["JUPYTER_RUNTIME_DIR"]), log)
            yield Server(folder, url, token)
        finally:
            process.terminate()
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def _url(process: subprocess.Popen[bytes], runtime: Path, log: Path) -> str:
    """Wait until the server has said where it is."""
    end = time.monotonic() + LIMIT
    while time.monotonic() < end:
        assert process.poll() is None, log.read_text("utf-8")[-4000:]
        for file in runtime.glob(f"jpserver-{process.pid}.json"):
            try:
                return str(json.loads(file.read_text("utf-8"))["url"])
            except ValueError:  # half of it is written
                break
        threading.Event().wait(0.05)
    raise AssertionError(log.read_text("utf-8")[-4000:])


@dataclass
class Tab:
    """A browser's page, and what went wrong in it."""

    page: Any
    server: Server
    complaints: list[str] = field(default_factory=list)  # of what is not Jupyter's own
    strangers: list[str] = field(default_factory=list)  # addresses on other machines

    def note(self, kind: str, text: str, where: str) -> None:
        """Keep an error or a warning, unless Jupyter's own programs made it."""
        theirs = ("static/", "lab/extensions/", "formgrader/")
        if not any(self.server.url + part in where for part in theirs):
            self.complaints.append(f"{kind}: {text} ({where})")


@contextmanager
def tab(browser: Any, server: Server, **options: Any) -> Iterator[Tab]:
    """Open an empty page; at the end nothing may have complained, or asked elsewhere."""
    settings = {
        "viewport": {"width": 1280, "height": 960},
        "reduced_motion": "reduce",
        "color_scheme": "null",  # Chromium's own: an override would win in the replays' frames
    }
    context = browser.new_context(**settings | options)
    context.set_default_timeout(LIMIT * 1000)
    opened = Tab(context.new_page(), server)

    def look(message: Any) -> None:
        if message.type in ("error", "warning"):
            opened.note(message.type, message.text, message.location.get("url", ""))

    def ask(route: Any) -> None:
        opened.strangers.append(route.request.url)
        route.abort()

    context.on("console", look)
    context.on("weberror", lambda e: opened.note("raised", str(e.error), str(e.error.stack)))
    context.route(lambda url: not url.startswith((server.url, "data:", "blob:", "about:")), ask)
    try:
        yield opened
    finally:
        context.close()
    said = [*opened.complaints, *opened.strangers]
    assert not said, "\n".join(said)


def picture(page: Any, name: str, clip: Any = None) -> None:
    """Keep a picture for the documentation, if COURSE_SCREENSHOTS is set."""
    if os.environ.get("COURSE_SCREENSHOTS"):
        page.screenshot(path=IMAGES / f"{name}.png", clip=clip, animations="disabled")
