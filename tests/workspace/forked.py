"""The page's Python in CPython: forks stand for its copies of memory, the stand-ins are the page's.

`forked.py FOLDER` reads orders from stdin, a JSON object each, and prints what came of it: of one
with `exercise`, `file`, `others` and `scenarios` the grading, of one with `file` and `arguments`
what the page says of the drive. The recordings stay in FOLDER.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "workspace" / "stand_ins"), str(ROOT)]

from workspace import runtime  # noqa: E402


def forked(call: Callable[[str], str], **order: object) -> str:
    """Return what a call says in a copy of this process."""
    ours, theirs = os.pipe()
    pid = os.fork()
    if pid == 0:
        leave = os._exit
        try:
            said = call(json.dumps(order)).encode()
            with os.fdopen(theirs, "wb") as out:
                out.write(said)
        except BaseException:
            sys.excepthook(*sys.exc_info())
        finally:
            sys.stderr.flush()
            leave(0)
    os.close(theirs)
    with os.fdopen(ours, "rb") as answer:
        said = answer.read().decode()
    os.waitpid(pid, 0)
    return said


def graded(page: runtime.Runtime, order: dict[str, object], scenarios: list[str]) -> str:
    """Drive and judge as the page's worker does."""
    for number, scenario in enumerate(scenarios):
        trial = {"file": order["file"], "others": order["others"], "scenario": scenario}
        trial["interrupt"] = number == 0
        outcome = json.loads(forked(page.trial, **trial))
        if "lead" in outcome:
            forked(page.trial, **trial, **outcome)
    return forked(page.judge, exercise=order["exercise"], file=order["file"], scenarios=scenarios)


def driven(page: runtime.Runtime, order: dict[str, object]) -> str:
    """Drive as the page's worker does, and make the replay."""
    said = json.loads(forked(page.drive, **order))
    if "lead" in said:
        said = json.loads(forked(page.drive, **order, **said))
    if "scenario" in said:
        replay = forked(page.replay, scenarios=[said["scenario"]], title="Drive")
        assert "<html" in replay
    return json.dumps(said)


if __name__ == "__main__":
    warm = runtime.warm(sys.argv[1])
    for line in sys.stdin:
        each = json.loads(line)
        print(driven(warm, each) if "arguments" in each else graded(warm, each, each["scenarios"]),
              flush=True)  # fmt: skip
