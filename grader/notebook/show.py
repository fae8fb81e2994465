"""Show text and HTML in a notebook, and progress bars that turn into their result.

Outside a notebook (IPython in a terminal, a plain program) only the text is printed. Nothing goes
to stderr: nbgrader takes that for a failure.
"""

import html
import sys
import time
from typing import Any

Bundle = dict[str, str]  # content by MIME type; "text/plain" is always there
BEAT = 0.25  # [s] between two updates of a bar


def shell() -> Any:
    """Return the IPython that this runs in; None outside of one, and IPython is not imported."""
    if "IPython" not in sys.modules:
        return None
    from IPython.core.getipython import get_ipython  # noqa: PLC0415

    return get_ipython()


def in_notebook() -> bool:
    """Return whether this runs in a kernel that displays HTML."""
    return hasattr(shell(), "kernel")


def execution_count() -> int | None:
    """Return the number of the cell that is running; None without IPython."""
    running = shell()
    return None if running is None else int(running.execution_count)


def tell(text: str) -> None:
    """Print a message without escape sequences, which a student's text in it may have."""
    from grader.report.facts import plain  # noqa: PLC0415

    print("\n".join(plain(line) for line in text.split("\n")), flush=True)


def show(bundle: Bundle) -> None:
    """Show a bundle below the cell."""
    if not in_notebook():
        print(bundle["text/plain"], flush=True)
        return
    import IPython.display  # noqa: PLC0415

    displays: Any = IPython.display
    displays.display(bundle, raw=True)


def preformatted(text: str) -> str:
    """Return text as HTML that keeps its lines."""
    style = (
        "white-space:pre-wrap;overflow-wrap:anywhere;background:none;color:inherit;"
        "font-family:var(--jp-code-font-family,monospace);font-size:13px;line-height:1.4"
    )
    return f'<pre style="{style}">{html.escape(text)}</pre>'


class Progress:
    """A bar below the cell while something runs; the result takes its place.

    Parameters
    ----------
    title
        What is running.
    """

    def __init__(self, title: str) -> None:
        self._title = title
        self._begin = time.monotonic()
        self._shown = -BEAT  # [s] since begin: when it was drawn last
        self._handle: Any = None
        self._state: tuple[float | None, str] = (None, "")
        if in_notebook():
            import IPython.display  # noqa: PLC0415

            displays: Any = IPython.display
            self._handle = displays.display(self._bundle(), raw=True, display_id=True)

    def update(self, share: float | None, words: str) -> None:
        """Show the progress: a share, 0 … 1 (None: unknown), and words."""
        self._state = (share, words)
        self.beat()

    def beat(self) -> None:
        """Redraw, at most every `BEAT` seconds: the elapsed time changes."""
        now = time.monotonic() - self._begin
        if self._handle is not None and now - self._shown >= BEAT:
            self._shown = now
            self._handle.update(self._bundle(), raw=True)

    def end(self, bundle: Bundle) -> None:
        """Replace the bar by the result."""
        if self._handle is not None:
            self._handle.update(bundle, raw=True)
        else:
            print(bundle["text/plain"], flush=True)

    def say(self, text: str) -> None:
        """Replace the bar by a message."""
        self.end({"text/plain": text, "text/html": preformatted(text)})

    def _bundle(self) -> Bundle:
        share, words = self._state
        seconds = time.monotonic() - self._begin
        said = f"{self._title}: {words} ({seconds:.0f} s)" if words else self._title
        return {"text/plain": said, "text/html": _bar_html(said, share)}


def _bar_html(said: str, share: float | None) -> str:
    percent = 100 * min(1.0, max(0.0, share or 0.0))
    value = "" if share is None else f' aria-valuenow="{percent:.0f}"'
    return (
        '<div style="max-width:720px;padding:4px 0">'
        f'<div style="font-size:13px;padding-bottom:5px">{html.escape(said)}</div>'
        f'<div role="progressbar" aria-label="{html.escape(said)}" aria-valuemin="0" '
        f'aria-valuemax="100"{value} '
        'style="height:8px;border-radius:4px;background:rgba(128,128,128,.28);overflow:hidden">'
        f'<div style="height:8px;width:{max(percent, 2):.1f}%;background:#2b7fba"></div>'
        "</div></div>"
    )
