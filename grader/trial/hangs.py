"""Where a node hangs, or waits without spinning: the student's line and loop, from its stacks.

The lines are quoted from what was handed in; the process could have changed its copy.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from grader.advice.rules import wait_for_good
from grader.course.beside import PYTHON
from grader.course.submission import Submission, read_regular_file
from grader.recording import Recording
from grader.trial.endings import BUSY_WAIT

ENTRY = re.compile(r'  File "(?P<file>[^"\n]+)", line (?P<line>\d{1,6}) in (?P<function>.{1,80})')
LOOP = re.compile(r"(async\s+)?(while|for)\b")
FUNCTION = re.compile(r"(async\s+def|def|class)\b")
CALLED = re.compile(r"\btarget\s*=\s*[\w.]+\(")  # Thread(target=self.work())
EXECUTORS = "rclpy/executors.py"
KERNEL = "rclpy_virtual_time/host/virtual"  # a thread in there waits for its turn
HALTS = {
    "hung": "the node did not come back from",
    "never_spun": "the node never spins: its program stays in",
    "stuck": "the node waits for good in",
}
WANTS = "give such a loop a time.sleep(0.05), or make it a timer's callback"
SPIN = (
    "a rate's timer fires while something spins: before the loop, threading.Thread(target="
    "rclpy.spin, args=(node,), daemon=True).start()"
)
MAX_FRAMES = 4
MAX_SOURCE = 160  # [characters] of a line
LOOP_TOLD = "loop: "
START_UP = "the start-up"


Sources = dict[str, list[str]]  # lines by file


class _Entry(NamedTuple):
    file: str
    line: int
    function: str

    @property
    def own(self) -> bool:
        """The file is the student's: their folder is not shown."""
        return not self.file.startswith(("/", "<"))


def located(recording: Recording, submission: Submission) -> Recording:
    """Return the recording; if its node hung, the outcome tells the student's lines first."""
    outcome = recording.outcome
    if outcome.kind not in HALTS:
        return recording
    if not (told := _account(outcome.detail, _sources(submission), outcome.kind)):
        return recording
    place, inner = told.splitlines()[:2]
    if outcome.kind == "hung" and place == f"in {START_UP}" and f"\n{LOOP_TOLD}" in told:
        told += f"\ntry: {WANTS}"
    line = inner if submission.package else inner.partition(", ")[2]  # there may be several
    text = f"{HALTS[outcome.kind]} {place.removeprefix('in ')} ({line})"
    outcome = replace(outcome, text=text, detail=f"{told}\n\n{outcome.detail}")
    return replace(recording, outcome=outcome)


def busy_wait(hung: Recording) -> str:
    """Say why a node that hung in virtual time runs in real time, and what its loop wants."""
    told = hung.outcome.detail.splitlines()
    loops = [line.removeprefix(LOOP_TOLD) for line in told if line.startswith(LOOP_TOLD)]
    return f"{BUSY_WAIT} ({(loops or ['such as `while not done: pass`'])[0]}): {WANTS}"


def _account(stacks: str, sources: Sources, kind: str) -> str:
    thread = _hanging(list(_threads(stacks)))
    place, own = START_UP, list[_Entry]()
    for entry in thread:
        if entry.file.endswith(EXECUTORS):
            place = "a callback"
            break
        if entry.own:
            own.append(entry)
    if not own:
        return ""
    inner = next(iter(_quoted(sources, own[0].file, own[0].line)), "")
    if place == START_UP and any(entry.function == "__init__" for entry in own):
        place = "the constructor"
    lines = [f"in {place}"]
    for entry in own[:MAX_FRAMES]:
        lines.append(f"{entry.file}, line {entry.line}, in {entry.function}")
        lines += [f"    {source}" for source in _quoted(sources, entry.file, entry.line)]
    if loop := _loop(own, sources):
        lines.append(f"{LOOP_TOLD}{loop}")
    quoted = [line for entry in own for line in _quoted(sources, entry.file, entry.line)]
    if any(CALLED.search(line) for line in quoted):
        lines.append("try: brackets after target call it here and now: write target=self.work")
    elif place == "the constructor":
        lines.append("try: the constructor has to end before anything can be called back")
    elif kind == "stuck" and (said := wait_for_good(inner)):  # every thread waits
        lines.append(f"try: {said}")
    elif kind == "never_spun" and re.search(r"rate\w*\.sleep\(", inner):
        lines.append(f"try: {SPIN}")
    return "\n".join(lines)


def _threads(stacks: str) -> Iterator[list[_Entry]]:
    """Yield the stacks of the threads, innermost first."""
    thread: list[_Entry] = []
    for line in stacks.splitlines():
        if match := ENTRY.fullmatch(line):
            thread.append(_Entry(match["file"], int(match["line"]), match["function"]))
        elif thread:
            yield thread
            thread = []
    if thread:
        yield thread


def _hanging(threads: Sequence[list[_Entry]]) -> list[_Entry]:
    """Return the stack of the thread that runs the student's code, not of one that waits."""
    own = [thread for thread in threads if any(entry.own for entry in thread)]
    busy = [thread for thread in own if KERNEL not in thread[0].file]
    return next(iter(busy or sorted(own, key=_distance)), [])


def _distance(thread: list[_Entry]) -> int:
    """Rank a callback's thread first, then one without an executor, then one that only spins."""
    outward = [entry.own for entry in thread if entry.own or entry.file.endswith(EXECUTORS)]
    return 1 if all(outward) else 0 if outward[0] else 2


def _loop(own: Sequence[_Entry], sources: Sources) -> str:
    """Return the innermost `while` around the lines, or else the innermost `for`."""
    loops = [loop for entry in own for loop in _around(sources.get(entry.file, []), entry.line)]
    loops.sort(key=lambda loop: not loop[1].startswith("while"))
    return f"line {loops[0][0]}, `{loops[0][1][:MAX_SOURCE]}`" if loops else ""


def _around(source: list[str], line: int) -> Iterator[tuple[int, str]]:
    """Yield the loops around a line of a function, innermost first."""
    if not 0 < line <= len(source):
        return
    depth = _indent(source[line - 1])
    if LOOP.match(source[line - 1].strip()):
        yield line, source[line - 1].strip()
    for number in range(line - 1, 0, -1):
        text = source[number - 1]
        if not text.strip() or text.lstrip().startswith("#") or _indent(text) >= depth:
            continue
        depth = _indent(text)
        if FUNCTION.match(text.strip()):
            return
        if LOOP.match(text.strip()):
            yield number, text.strip()


def _indent(text: str) -> int:
    text = text.expandtabs(8)
    return len(text) - len(text.lstrip())


def _quoted(sources: Sources, file: str, line: int) -> list[str]:
    source = sources.get(file, [])
    text = source[line - 1].strip()[:MAX_SOURCE] if 0 < line <= len(source) else ""
    return [text] if text else []


def _sources(submission: Submission) -> Sources:
    """Return the lines of the files that were handed in."""
    found = {}
    for name, path in submission.files.items():
        if not name.endswith(PYTHON):
            continue
        try:
            found[name] = read_regular_file(path).decode("utf-8", "replace").splitlines()
        except OSError:
            continue
    return found
