"""What all tests share: warm fork servers, and things that are made once."""

import fcntl
import gc
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from grader.course.exercises import ROOT
from grader.launchers import ForkServerPool, launcher_pool
from grader.trial.kept import RECORDINGS, KeptRecordings
from rclpy_virtual_time.link.hosts import ForkServer

MadeOnce = Callable[[str, Callable[[Path], object]], Path]
# jsonschema builds 38 grammars for IRIs where it finds this, 1.7 s in each worker
sys.modules["rfc3987_syntax"] = None  # type: ignore[assignment]
LONG = ("browser",)  # folders with what takes long by its nature
CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
CHROMIUM_ARGUMENTS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--disable-background-networking",
    "--disable-component-update",
    "--no-first-run",
]


@pytest.fixture(scope="session", autouse=True)
def nobodys_state(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep what `course` remembers and keeps out of the home of the person who tests."""
    with pytest.MonkeyPatch.context() as patch:
        for kind in ("STATE", "CACHE"):
            patch.setenv(f"XDG_{kind}_HOME", str(tmp_path_factory.mktemp(kind.lower())))
        yield


@pytest.fixture(autouse=True)
def any_path() -> Iterator[None]:
    """Take back what a batch leaves in this process: programs of other tests import their own."""
    yield
    os.environ.pop("PYTHONSAFEPATH", None)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[object]:
    """Let no garbage be looked for in what is collected, now or later: all of it stays."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(tryfirst=True)  # before `-m` selects
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave whole folders to `make test-long`."""
    here = Path(__file__).parent
    for item in items:
        inside = item.path.is_relative_to(here) and item.path.relative_to(here).parts[0] in LONG
        if inside and not item.get_closest_marker("quick"):
            item.add_marker(pytest.mark.long)


@pytest.fixture(scope="session")
def forkservers() -> Iterator[ForkServerPool]:
    """A warm fork server for each set of libraries that is asked for."""
    with launcher_pool() as pool:
        yield pool


@pytest.fixture(scope="session")
def forkserver(forkservers: ForkServerPool) -> ForkServer:
    """A warm fork server without libraries."""
    return forkservers.of()


@pytest.fixture(scope="session")
def made_once(tmp_path_factory: pytest.TempPathFactory) -> MadeOnce:
    """Make a folder by its name, once in a session, whichever of pytest's workers comes first."""
    base = tmp_path_factory.getbasetemp()
    root = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base

    def folder_of(name: str, make: Callable[[Path], object]) -> Path:
        folder = root / name
        with (root / f"{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not (folder / "made").exists():
                shutil.rmtree(folder, ignore_errors=True)
                folder.mkdir()
                make(folder)
                (folder / "made").touch()
        return folder

    return folder_of


@pytest.fixture(scope="session")
def recordings(made_once: MadeOnce) -> KeptRecordings:
    """Recordings of earlier runs of the tests and the proof, for tests of what judges them."""
    kept = KeptRecordings(RECORDINGS)
    made_once("tidy", lambda _: kept.tidy())
    return kept


@pytest.fixture(scope="session")
def wheel(made_once: MadeOnce) -> Path:
    """The course's wheel, as `make wheel` builds it."""
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "wheel", "--quiet"]
    options = ["--no-deps", "--no-build-isolation", str(ROOT), "--wheel-dir"]
    made = made_once("wheel", lambda folder: subprocess.run([*pip, *options, folder], check=True))
    return next(made.glob("*.whl"))


@pytest.fixture(scope="session")
def site(made_once: MadeOnce) -> Path:
    """The folder of the lesson's site. Its build has nothing to complain about."""
    for library in ("sphinx", "myst_parser", "furo"):
        pytest.importorskip(library, reason=f"{library} is not installed: pip install '.[site]'")
    return made_once("site", build_site) / "html"


def build_site(folder: Path) -> None:
    """Build the lesson; a warning is an error."""
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-n", "-q", "-b", "html"]
    command += ["-d", str(folder / "doctrees"), str(ROOT / "lessons"), str(folder / "html")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr


# --- a browser -----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """A headless Chromium."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    path = next(filter(None, map(shutil.which, CHROMIUM)), None)
    if path is None:
        pytest.skip(f"no browser: none of {', '.join(CHROMIUM)} is on the PATH")
    with sync_api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=path, args=CHROMIUM_ARGUMENTS)
        yield chromium
        chromium.close()


@pytest.fixture
def open_file(browser: Any) -> Iterator[Callable[..., Any]]:
    """Open files in a browser; at the end none may have complained, or asked for anything else."""
    contexts, complaints, requests = [], [], []

    def failed(request: Any) -> None:
        if request.failure != "net::ERR_ABORTED":  # as by a click that leads to another page
            complaints.append(request.url)

    def open_(file: Path, may_complain: bool = False, **options: Any) -> Any:
        settings = {"viewport": {"width": 1280, "height": 800}, "reduced_motion": "reduce"}
        context = browser.new_context(**settings | options)
        contexts.append(context)
        page = context.new_page()
        if not may_complain:
            page.on("console", lambda message: complaints.append(message.text))
            page.on("pageerror", lambda error: complaints.append(str(error)))
            page.on("requestfailed", failed)
        page.on("request", lambda request: requests.append(request.url))
        page.goto(file.as_uri())
        return page

    yield open_
    for context in contexts:
        context.close()
    assert complaints == []
    assert [url for url in requests if not url.startswith(("file:", "data:", "about:"))] == []


@pytest.fixture(scope="session")
def axe() -> Callable[[Any], list[str]]:
    """Return what axe-core has against a page: rule, how bad, where."""
    package = pytest.importorskip("axe_playwright_python", reason="axe is not installed")
    source = Path(package.__file__).with_name("axe.min.js").read_text("utf-8")

    def violations(page: Any) -> list[str]:
        page.evaluate(f"() => {{ {source} }}")
        found = page.evaluate("axe.run(document, { resultTypes: ['violations'], iframes: false })")
        return [
            f"{rule['id']} ({rule['impact']}): {' '.join(map(str, node['target']))}"
            for rule in found["violations"]
            for node in rule["nodes"]
        ]

    return violations
