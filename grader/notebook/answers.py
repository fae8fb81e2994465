"""What a notebook is shown of a grading: table and replays."""

import io
import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from grader.grading.attempts import since_last
from grader.grading.grading import Grading
from grader.notebook.orders import Graded
from grader.recording import Recording
from grader.report.page import embedded_payload, json_text, page_html
from grader.report.terminal import render_terminal

WIDTH = 100  # [characters] of the tables
MAX_REPLAYS = 400_000  # [characters] of the replays that a notebook stores
MIN_MOTION = 0.2  # [m] that make a drive worth seeing


def graded(grading: Grading, path: Path) -> Graded:
    """Return what a notebook shows of the grading of a file, and note the attempt."""
    result, changed = grading.as_dict(), since_last(grading, path)
    console = Console(file=io.StringIO(), width=WIDTH, color_system=None, legacy_windows=False)
    with console.capture() as said:
        render_terminal(result, console, changed)
    runs = worth_seeing(grading)
    first = (runs[0].scenario.title or runs[0].name) if runs else ""
    page = _page(result["checks"], runs, grading.exercise.title)
    return Graded(json_text(result), said.get(), page, first, changed)


def worth_seeing(grading: Grading) -> list[Recording]:
    """Return the recordings to show: those with failures, the first failure first; then drives.

    Runs in which nothing failed and the robot hardly moved are left out.
    """
    failed = [c.scenario for c in grading.checks if c.outcome == "fail" and c.scenario is not None]
    timed = [
        c.scenario
        for c in grading.checks
        if c.outcome == "fail" and c.scenario is not None and c.time is not None
    ]
    order = list(dict.fromkeys([*timed[:1], *failed]))
    by_name = {recording.name: recording for recording in grading.recordings}
    shown = [by_name[name] for name in order if name in by_name]
    return shown + [r for r in grading.recordings if r.name not in order and _moved(r)]


def _moved(recording: Recording) -> bool:
    x, y = recording.truth.x, recording.truth.y
    return len(x) > 0 and float(max(np.ptp(x), np.ptp(y))) > MIN_MOTION


def _page(checks: Sequence[Any], runs: Sequence[Recording], title: str) -> str:
    """Return a page with as many replays as fit in a notebook, at least one."""
    if not runs:
        return ""
    payload = embedded_payload(checks, runs, title)
    lengths = itertools.accumulate(len(json_text(replay)) for replay in payload["replays"])
    count = sum(length <= MAX_REPLAYS for length in lengths)
    return page_html({**payload, "replays": payload["replays"][: max(1, count)]})
