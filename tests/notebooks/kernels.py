"""A real kernel for tests: run a cell, look at what came out of it."""

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from jupyter_client.kernelspec import KernelSpec
from jupyter_client.manager import KernelManager

LIMIT = 50.0  # [s] of one cell
Display = dict[str, Any]  # data by MIME type


@dataclass
class Said:
    """What a cell brought, as a notebook would keep it."""

    status: str = "ok"
    stdout: str = ""
    stderr: str = ""
    displays: list[Display] = field(default_factory=list)  # updates applied
    result: Display | None = None
    traceback: str = ""
    states: list[Display] = field(default_factory=list)  # every display and update, in order

    @property
    def text(self) -> str:
        """All that a person without HTML sees."""
        shown = [display.get("text/plain", "") for display in self.displays]
        result = [] if self.result is None else [self.result.get("text/plain", "")]
        return "\n".join([self.stdout, *shown, *result])

    @property
    def html(self) -> str:
        return "\n".join(display.get("text/html", "") for display in self.displays)


class Kernel:
    """One kernel and a client that talks to it."""

    def __init__(self, manager: Any, client: Any) -> None:
        self.manager = manager
        self.client = client

    def run(self, cell: str, when: Callable[[Said], bool] | None = None) -> Said:
        """Run a cell. As soon as `when` says so, the kernel is interrupted."""
        said = Said()
        identified: dict[str, int] = {}
        sent = threading.Event()

        def hook(message: dict[str, Any]) -> None:
            self._take(message["msg_type"], message["content"], said, identified)
            if when is not None and not sent.is_set() and when(said):
                sent.set()
                self.manager.interrupt_kernel()

        reply = self.client.execute_interactive(
            cell, output_hook=hook, timeout=LIMIT, allow_stdin=False
        )
        said.status = reply["content"]["status"]
        return said

    def judge(self) -> int:
        """The process of its judge."""
        said = self.run("from grader.notebook.child import JUDGE\nprint(JUDGE.pid)")
        return int(said.stdout)

    @staticmethod
    def _take(kind: str, content: Any, said: Said, identified: dict[str, int]) -> None:
        if kind == "stream":
            setattr(said, content["name"], getattr(said, content["name"]) + content["text"])
        elif kind == "error":
            said.traceback = "\n".join(content["traceback"])
        elif kind == "execute_result":
            said.result = content["data"]
        elif kind in ("display_data", "update_display_data"):
            said.states.append(content["data"])
            name = content.get("transient", {}).get("display_id")
            if name in identified:
                said.displays[identified[name]] = content["data"]
            elif kind == "display_data":
                said.displays.append(content["data"])
                if name:
                    identified[name] = len(said.displays) - 1


@contextmanager
def started(folder: Path, argv: Sequence[str], **environment: str) -> Iterator[Kernel]:
    """Run a kernel in a folder."""
    manager = KernelManager()
    manager._kernel_spec = KernelSpec(argv=[*argv, "-f", "{connection_file}"], language="python")
    manager.start_kernel(cwd=str(folder), env=environment)
    client = manager.client()
    try:
        client.start_channels()
        client.wait_for_ready(timeout=LIMIT)
        yield Kernel(manager, client)
    finally:
        client.stop_channels()
        manager.shutdown_kernel(now=True)
        manager.cleanup_resources()


def save(kernel: Kernel, file: str, source: str) -> None:
    """Run a `%%node` cell."""
    said = kernel.run(f"%%node {file}\n{source}")
    assert said.text.strip().startswith(f"Saved {file}"), said


def gone(pid: int, patience: float = 10.0) -> bool:
    """Wait until a process has ended."""
    end = time.monotonic() + patience
    while time.monotonic() < end:
        status = Path(f"/proc/{pid}/stat")
        if not status.exists() or status.read_text().rpartition(")")[2].split()[0] == "Z":
            return True
        threading.Event().wait(0.02)
    return False
