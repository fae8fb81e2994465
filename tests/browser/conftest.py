"""Pages of synthetic payloads in a real Chromium, and the site from a server."""

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from served_site import served

from grader.report.page import page_html

ARGUMENTS = ["--no-sandbox", "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"]
HEARTBEAT = "/api/service-worker-heartbeat"  # of JupyterLite, at its server's root


@pytest.fixture
def open_page(open_file: Callable[..., Any], tmp_path: Path) -> Callable[..., Any]:
    """Open a payload's page."""

    def open_(payload: dict[str, Any], **options: Any) -> Any:
        file = tmp_path / "report.html"
        file.write_text(page_html(payload), encoding="utf-8")
        return open_file(file, **options)

    return open_


@pytest.fixture(scope="module")
def address(site: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    with served(site, tmp_path_factory.mktemp("served")) as address:
        yield address


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
def open_served(chromium: Any, address: str) -> Iterator[Any]:
    """Open a page of the site; at the end no other host was asked for anything."""
    asked: list[str] = []
    contexts = []

    def open_(place: str, script: str = "", **options: Any) -> Any:
        settings = {"viewport": {"width": 1280, "height": 800}, "reduced_motion": "reduce"}
        context = chromium.new_context(**settings | options)
        contexts.append(context)
        context.add_init_script(script)
        page = context.new_page()
        page.on("request", lambda request: asked.append(request.url))
        page.goto(f"{address}/{place}")
        return page

    yield open_
    for context in contexts:
        context.close()
    ours = (address, f"{address.partition('/below/')[0]}{HEARTBEAT}", "blob:", "data:", "about:")
    assert [url for url in asked if not url.startswith(ours)] == []
