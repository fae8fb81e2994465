"""Run a program while a bar below the cell shows the last line that it printed."""

import os
import select
import subprocess
from collections.abc import Callable, Mapping, Sequence

from grader.notebook.show import BEAT, Progress

CHUNK = 1 << 16  # [bytes]
MOST_OUTPUT = 80_000  # [bytes] that are kept, the last ones


def run(
    command: Sequence[str],
    bar: Progress,
    environment: Mapping[str, str],
    clean: Callable[[str], str] = str,
) -> tuple[int, str]:
    """Run a program; return its exit code, and what it printed. An interrupt ends it.

    `clean`: what makes a line of its output fit to be shown.
    """
    process = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        env=environment,
        start_new_session=True,
    )
    assert process.stdout is not None
    said = b""
    try:
        while True:
            if select.select([process.stdout], [], [], BEAT)[0]:
                data = os.read(process.stdout.fileno(), CHUNK)
                if not data:
                    break
                said = (said + data)[-MOST_OUTPUT:]
            last = said.decode("utf-8", "replace").strip().rpartition("\n")[2]
            bar.update(None, clean(last)[:80] or "at work")
        return process.wait(), said.decode("utf-8", "replace")
    finally:
        if process.poll() is None:
            os.killpg(process.pid, 9)
        process.wait()
        process.stdout.close()
