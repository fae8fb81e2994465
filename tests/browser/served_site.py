"""The built site on a plain server, below a sub-path; and what one does in its workspace."""

import contextlib
import functools
import http.server
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

SLOW = 1_200_000  # [ms] for all of a busy machine's trials


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: object) -> None:
        pass


@contextlib.contextmanager
def served(site: Path, root: Path) -> Iterator[str]:
    """Have the site on a plain server, below a sub-path."""
    (root / "below" / "it").mkdir(parents=True)
    (root / "below" / "it" / "course").symlink_to(site)
    handler = functools.partial(Quiet, directory=str(root))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/below/it/course"
        server.shutdown()


def type_in(page: Any, text: str) -> None:
    page.locator(".cm-content:visible").click()
    page.keyboard.press("Control+A")
    page.keyboard.insert_text(text)


def settle(page: Any) -> str:
    """Wait until nothing is under way; return what the page says of it."""
    page.locator("dialog.workspace[aria-busy=false]").wait_for(timeout=SLOW)
    return str(page.locator(".ws-status").inner_text())


def typed(page: Any) -> str:
    return str(page.locator(".cm-content:visible").inner_text())


def stand_at(page: Any, seconds: float, panel: str) -> None:
    """Have the replay stand at a moment, once it is there and knows where it began."""
    frame = page.locator(".ws-replay iframe").element_handle().content_frame()
    frame.wait_for_load_state()
    frame.evaluate("(t) => { window.replayPlayer.pause(); window.replayPlayer.seek(t); }", seconds)
    page.locator(f"{panel} summary", has_text=f"{seconds:.2f} s").wait_for()
