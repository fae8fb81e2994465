"""Run programs once in virtual time, with messages to them whose times are known beforehand."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from operator import itemgetter
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from rclpy_virtual_time.host import frames
from rclpy_virtual_time.link.exchange import HostDied, HostForged
from rclpy_virtual_time.link.launcher import Launcher
from rclpy_virtual_time.link.link import Link
from rclpy_virtual_time.link.log import LogLine
from rclpy_virtual_time.link.scratch import fresh_folder
from rclpy_virtual_time.link.settings import EPOCH

SLICE = 997_331_087  # [ns] a prime at a time: hardly one ends where a timer is due
GRACE = 1.0  # [s] for the end of a process that has hung up
AT_ONCE = frames.Discovery()


@dataclass
class ProgramsRun:
    """What programs did until a time, or until one of them ended."""

    now: int  # [ns] the time that they came to
    published: list[frames.Published]
    endpoints: list[frames.EndpointReport]
    notes: dict[tuple[str, str, str], frames.Note]  # the latest by kind, what it is about, line
    log: tuple[LogLine, ...] = ()
    truncated: bool = False  # the log, because they printed too much
    ended: frames.Ended | None = None  # how one ended by itself, and all the others with it
    spun: bool = False  # an executor has waited for work
    stuck: int | None = None  # [ns] since when nothing in them can ever go on
    stacks: str = ""  # of their threads, where they never spun or are stuck


def run_programs(
    launcher: Launcher,
    folder: Path,
    programs: Sequence[frames.ProgramStart],
    *,
    until: int,
    deliveries: Iterable[tuple[int, frames.Delivery]] = (),
    offers: Iterable[frames.Offer] = (),
    discovery: frames.Discovery = AT_ONCE,
    seed: int = 0,
    epoch: int = EPOCH,
    limit: float = 20.0,
    **options: Any,
) -> ProgramsRun:
    """Run programs in a copy of a folder until a time [ns], and return what they did.

    `deliveries` are a robot's messages: when [ns], and what; their topics are among `offers`.
    `epoch` is the launcher's; `limit` is the wall time of the start-up and of each step [s];
    `options` are `stdin`, `keys`, `env` and `charge_compute` of `Start`.

    Raises HostDied (with the exit status), HostHung, HostForged, Flood or Excess of their process,
    with a note of what it had printed, and EngineError of the machine. A question is forged: nobody
    answers here.
    """
    lead, due = 0, sorted(deliveries, key=itemgetter(0))
    while True:
        with fresh_folder() as place:
            shutil.copytree(folder, place, symlinks=True, dirs_exist_ok=True)
            start = frames.Start(
                tuple(replace(program, file=str(place / program.file)) for program in programs),
                epoch, seed, tuple(offers), lead=lead, discovery=discovery, **options,
            )  # fmt: skip
            with launcher.host(place) as link:
                try:
                    found = _run(link, start, due, until, limit, f"{place}/")
                except Exception as error:
                    if isinstance(error, HostDied):
                        error.args = (link.wait(GRACE),)
                    error.add_note("\n".join(line.text for line in link.log()))
                    raise
        if isinstance(found, ProgramsRun):
            return found
        lead = found.lead  # a program sleeps before it spins: it has to start so much earlier


def _run(
    link: Link, start: frames.Start, due: Sequence[tuple[int, frames.Delivery]],
    until: int, limit: float, place: str,
) -> ProgramsRun | frames.Slept:  # fmt: skip
    at = {time: tuple(each[1] for each in now) for time, now in groupby(due, key=itemgetter(0))}
    moments = sorted({0, until, *range(0, until, SLICE), *(time for time in at if time < until)})
    steps: list[tuple[int, int, frames.Start | frames.Run]] = [(0, 0, start)]
    steps += ((now, then, frames.Run(then, at.get(now, ()))) for now, then in pairwise(moments))
    run = ProgramsRun(0, [], [], {})
    for began, agreed, frame in steps:
        said, _ = link.run(frame, limit)
        if isinstance(said, frames.Slept):
            if frame is start and not start.lead:
                return said
            raise HostForged("a start in the middle of the run")
        if isinstance(said, frames.Settled) and (said.asked or said.now != agreed):
            raise HostForged(f"time {said.now} or a question, where {agreed} was agreed on")
        times = [began, *(message.time for message in said.published), said.now, agreed]
        if times != sorted(times):
            raise HostForged(f"times that go back, or beyond {agreed}")
        run.now = said.now
        run.published += said.published
        run.endpoints += said.endpoints
        run.notes |= {(note.kind, note.about, note.line): note for note in said.notes}
        if isinstance(said, frames.Ended):
            text, detail = (each.replace(place, "") for each in (said.text, said.detail))
            run.ended = replace(said, text=text, detail=detail)
            break
        run.spun = run.spun or said.spinning
        goes_on = said.spinning or said.asleep
        run.stuck = None if goes_on else said.now if run.stuck is None else run.stuck
    run.log = tuple(LogLine(x.time, x.level, x.text.replace(place, "")) for x in link.log())
    run.truncated = link.stdout.truncated or link.stderr.truncated
    if run.ended is None and not (run.spun and run.stuck is None):
        run.stacks = link.stacks().replace(place, "")
    return run
