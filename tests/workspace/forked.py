"""The page's Python in CPython: forks stand for its copies of memory.

`forked.py FOLDER` has the page's files from FOLDER, and no others of the course; with `alone` after
it no threads, as in a browser without JSPI. It reads orders from stdin, a JSON object each, and
prints what came of it: of one with `exercise`, `file`, `others` and `scenarios` the grading, or
the race if it is to `tell`; of another, to `tell` or with `arguments`, what the page says of the
drive. The recordings stay in FOLDER.
"""

import collections
import json
import os
import sys
from collections.abc import Callable

from greenlet import getcurrent, greenlet

sys.path[:0] = [f"{sys.argv[1]}/workspace/page_packages", sys.argv[1]]

from workspace import runtime  # noqa: E402


class Greenlets:
    """Stacks that wait for one another, as the worker has them of promises (web/worker.js)."""

    def __init__(self) -> None:
        self._waiting: dict[int, greenlet] = {}
        self._ready: collections.deque[greenlet] = collections.deque()
        self._hub = greenlet(self._go_on)

    def begin(self, number: int) -> None:
        self._ready.append(greenlet(lambda: warm.thread(number), self._hub))

    def wait(self, number: int) -> None:
        self._waiting[number] = getcurrent()
        self._hub.switch()

    def wake(self, number: int) -> None:
        self._ready.append(self._waiting.pop(number))

    def _go_on(self) -> None:
        while True:
            self._ready.popleft().switch()


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
    """Drive and judge, or race, as the page's worker does."""
    races = "tell" in order
    for number, scenario in enumerate(scenarios):
        trial = {"file": order["file"], "others": order["others"], "scenario": scenario}
        how = {"interrupt": number == 0, "seed": order.get("seed")}
        trial |= {"tell": True} if races else how
        outcome = json.loads(forked(page.trial, **trial))
        while "lead" in outcome:
            outcome = json.loads(forked(page.trial, **trial, **outcome))
    call = page.race if races else page.judge
    return forked(call, **order)


def driven(page: runtime.Runtime, order: dict[str, object]) -> str:
    """Drive as the page's worker does, and make the replay."""
    call = page.trial if "tell" in order else page.drive
    said = json.loads(forked(call, **order))
    while "lead" in said:
        said = json.loads(forked(call, **order, **said))
    if "scenario" in said:
        replay = forked(page.replay, scenarios=[said["scenario"]], title="Drive")
        assert "<html" in replay
    return json.dumps(said)


if __name__ == "__main__":
    warm = runtime.warm(sys.argv[1], browser=None if sys.argv[2:] else Greenlets())
    for line in sys.stdin:
        each = json.loads(line)
        print(graded(warm, each, each["scenarios"]) if "exercise" in each else driven(warm, each),
              flush=True)  # fmt: skip
