"""Three real browsers, each as far as a test needs it: open, evaluate, type, take a picture.

Chromium comes by playwright, Firefox by its own WebDriver BiDi, WebKitGTK by its WebKitWebDriver,
on a screen of Xvfb's. Where one is not there, its tests are skipped.
"""

import contextlib
import itertools
import json
import os
import re
import shutil
import socket
import subprocess
from base64 import b64decode
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import pytest

PATIENCE = 1200  # [s] of a script, on a busy machine
KEYS = {"Enter": "\ue007", "Control": "\ue009", "Shift": "\ue008"}
# Whatever an expression comes to, once its promise is kept
KEPT = "(async () => JSON.stringify(await ({})) ?? 'null')()"
# The text of the file that a click saves
SAVED = """(async () => {
  const make = URL.createObjectURL;
  const saved = new Promise((keep) => {
    URL.createObjectURL = (blob) => { keep(blob); return make(blob); };
  });
  CLICK;
  return (await saved).text();
})()"""


@dataclass
class Tab:
    """What a test does in one: the first four as each browser has them."""

    open: Callable[[str], object]
    evaluate: Callable[[str], str]
    act: Callable[[list[dict[str, Any]]], object]  # what one of WebDriver's keyboards does
    picture: Callable[[], bytes]

    def value(self, script: str) -> Any:
        return json.loads(self.evaluate(KEPT.format(script)))

    def type(self, text: str) -> None:
        for key in text:
            self.press(key)

    def press(self, *keys: str) -> None:
        """Press keys together."""
        steps = [("keyDown", key) for key in keys] + [("keyUp", key) for key in keys[::-1]]
        actions = [{"type": way, "value": KEYS.get(key, key)} for way, key in steps]
        self.act([{"type": "key", "id": "keys", "actions": actions}])


def _path(name: str) -> str:
    path = shutil.which(name)
    if path is None:
        pytest.skip(f"no browser: {name} is not on the PATH")
    return path


@contextlib.contextmanager
def _started(*command: str, **more: Any) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(command, text=True, **more) as process:
        try:
            yield process
        finally:
            process.terminate()


def _said(lines: IO[str] | None, pattern: str) -> str:
    assert lines is not None
    return next(filter(None, (re.search(pattern, line) for line in lines)))[1]


@contextlib.contextmanager
def _chromium(_: Path) -> Iterator[Tab]:
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    path = _path("chromium")
    with sync_api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        page = chromium.new_page()
        tab = Tab(page.goto, page.evaluate, list, page.screenshot)
        tab.press = lambda *keys: page.keyboard.press("+".join(keys))  # type: ignore[method-assign]
        tab.type = page.keyboard.type
        yield tab
        chromium.close()


@contextlib.contextmanager
def _firefox(folder: Path) -> Iterator[Tab]:
    websocket = pytest.importorskip("websocket", reason="websocket-client is not installed")
    command = [_path("firefox"), "--headless", "--no-remote", "--profile", str(folder)]
    environment = {**os.environ, "HOME": str(folder), "MOZ_DISABLE_CONTENT_SANDBOX": "1"}
    with _started(
        *command, "--remote-debugging-port=0", stderr=subprocess.PIPE, env=environment
    ) as process:
        place = _said(process.stderr, r"listening on (ws://\S+)")
        link = websocket.create_connection(
            f"{place}/session", timeout=PATIENCE, suppress_origin=True
        )
        numbers = itertools.count(1)

        def ask(method: str, **parameters: Any) -> Any:
            number = next(numbers)
            link.send(json.dumps({"id": number, "method": method, "params": parameters}))
            answers = iter(lambda: json.loads(link.recv()), None)
            answer = next(each for each in answers if each.get("id") == number)
            assert answer["type"] == "success", answer
            return answer["result"]

        ask("session.new", capabilities={})
        tab = {"context": ask("browsingContext.getTree")["contexts"][0]["context"]}
        yield Tab(
            lambda url: ask("browsingContext.navigate", url=url, wait="complete", **tab),
            lambda script: ask("script.evaluate", expression=script, target=tab, awaitPromise=True)[
                "result"
            ]["value"],
            lambda actions: ask("input.performActions", actions=actions, **tab),
            lambda: b64decode(ask("browsingContext.captureScreenshot", **tab)["data"]),
        )
        link.close()


@contextlib.contextmanager
def _webkit(folder: Path) -> Iterator[Tab]:
    urllib3 = pytest.importorskip("urllib3", reason="urllib3 is not installed")
    driver, screen = _path("WebKitWebDriver"), _path("Xvfb")
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    tell = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    with _started(screen, "-displayfd", "1", "-screen", "0", "1280x800x24", **tell) as shown:
        display = f":{_said(shown.stdout, '([0-9]+)')}"
        environment = {**os.environ, "HOME": str(folder), "DISPLAY": display}
        with _started(driver, f"--port={port}", env=environment):
            address = f"http://127.0.0.1:{port}/session"
            retry = urllib3.Retry(connect=20, backoff_factor=0.1)

            def ask(method: str, path: str = "", **body: Any) -> Any:
                answer = urllib3.request(
                    method, address + path, json=body or None, retries=retry, timeout=PATIENCE
                )
                assert answer.status == 200, answer.data
                return answer.json()["value"]

            made = ask("POST", capabilities={"alwaysMatch": {"timeouts": {"script": None}}})
            address += f"/{made['sessionId']}"
            yield Tab(
                lambda url: ask("POST", "/url", url=url),
                lambda script: ask("POST", "/execute/sync", script=f"return {script}", args=[]),
                lambda actions: ask("POST", "/actions", actions=actions),
                lambda: b64decode(ask("GET", "/screenshot")),
            )
            ask("DELETE")


BROWSERS = {"chromium": _chromium, "firefox": _firefox, "webkit": _webkit}
