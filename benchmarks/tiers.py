"""Is a live robot judged like the one in virtual time? The same solutions in both tiers.

Every solution is graded once in virtual time and several times in real time, on DDS. Prints, side
by side, score and failed checks; what the machine's stalls left undecided is said, not counted as
equal. What is done already is read from `--keep FILE`; `--page PAGE FILE …` grades nothing, but
writes what such files hold as a page of tables. Ends with 1 if any solution was judged differently.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Iterable
from pathlib import Path

import msgspec

from grader.authoring.claims import Claim, claims, complete
from grader.course.exercises import all_exercises, find_exercise
from grader.grading.grading import grade_submission
from grader.grading.plugin import ERROR, FAIL, INCONCLUSIVE, UNAVAILABLE
from grader.link.hosts import ForkServer
from sim.messages import EPOCH_NS

PAGE_HEAD = """\
# Both tiers, side by side

What `python benchmarks/tiers.py` found: each solution graded in virtual time (Tier 1) and in real
time, on DDS (Tier 2), by the same checks. The machine had 2 processors and was kept busy by other
tests. Of references the core checks were run; of a mutant the field checks too where it fails one.
"""


class Verdict(msgspec.Struct, frozen=True):
    """What one grading said."""

    solution: str
    tier: int
    run: int
    field: bool  # a field check failed
    score: int
    most: int
    failed: tuple[str, ...]
    undecided: tuple[str, ...]  # ERROR or INCONCLUSIVE
    seconds: float  # wall time of the grading
    load: float  # of the machine, at its end
    messages: dict[str, str] = {}  # of the failed and the undecided, by check


def main() -> int:
    """Grade and print; 1 if the tiers differ."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("exercises", nargs="*", help="all by default")
    parser.add_argument("--runs", type=int, default=1, help="gradings in real time of each")
    parser.add_argument("--mutants", action="store_true", help="the wrong ones, not the references")
    parser.add_argument("--field", action="store_true", help="field checks of references too")
    parser.add_argument("--keep", type=Path, help="read and add verdicts (JSON lines)")
    parser.add_argument("--page", type=Path, nargs="+", metavar=("PAGE", "FILE"))
    options = parser.parse_args()
    if options.page:
        page, *files = options.page
        page.write_text(_page([verdict for file in files for verdict in _read(file)]))
        return 0
    exercises = [find_exercise(name) for name in options.exercises] or all_exercises()
    done = {(v.solution, v.tier, v.run): v for v in _read(options.keep)}
    kind = "mutant" if options.mutants else "reference"
    differing = undecided = 0
    for exercise in exercises:
        with ForkServer(EPOCH_NS, libraries=exercise.libraries) as forkserver:
            for claim in claims(exercise):
                if claim.kind != kind or claim.lacks:
                    continue
                verdicts: list[Verdict] = []
                for tier, run in [(1, 0), *((2, run) for run in range(options.runs))]:
                    verdict = done.get((claim.name, tier, run))
                    if verdict is None:
                        # field checks are judged when the core is full: few mutants get there
                        wrong = options.mutants and (not verdicts or verdicts[0].field)
                        field = options.field or wrong
                        verdict = _grade(claim, forkserver, tier, run, field=field)
                        _add(options.keep, verdict)
                    verdicts.append(verdict)
                same, unsure = _print(verdicts)
                differing += not same
                undecided += unsure
    print(f"\n{differing} solutions judged differently, {undecided} gradings left undecided")
    return 1 if differing else 0


def _grade(claim: Claim, forkserver: ForkServer, tier: int, run: int, *, field: bool) -> Verdict:
    begin = time.perf_counter()
    with complete(claim) as submission:
        grading = grade_submission(
            claim.exercise,
            submission,
            forkserver,
            file=claim.exercise.files[0],
            field=field,
            tier=tier,
        )
    judged = [check for check in grading.checks if check.outcome != UNAVAILABLE]
    failed = [check for check in judged if check.outcome == FAIL]
    unsure = [check for check in judged if check.outcome in (ERROR, INCONCLUSIVE)]
    return Verdict(
        claim.name,
        tier,
        run,
        any(check.kind == "field" for check in failed),
        grading.score,
        sum(check.max_points for check in judged),
        tuple(sorted(check.id for check in failed)),
        tuple(sorted(check.id for check in unsure)),
        time.perf_counter() - begin,
        os.getloadavg()[0],
        {check.id: check.message for check in (*failed, *unsure)},
    )


def _print(verdicts: list[Verdict]) -> tuple[bool, int]:
    """Print a line for a solution; return whether the tiers agree and how many were undecided."""
    virtual, *live = verdicts
    unsure = [v for v in live if v.undecided]
    sure = [v for v in live if not v.undecided]
    other = [v for v in sure if not _same(virtual, v)]
    scores = ", ".join(f"{v.score}{'?' if v.undecided else ''}" for v in live)
    seconds = sum(v.seconds for v in live) / len(live) if live else 0.0
    load = max((v.load for v in live), default=0.0)
    print(
        f"{'!' if other else '?' if unsure else ' '} {virtual.solution:58} "
        f"{virtual.score:3} of {virtual.most:3} | {scores:24} {seconds:4.0f} s, load {load:3.1f}  "
        f"{', '.join(virtual.failed)}",
        flush=True,
    )
    for verdict in (*other, *unsure):
        for check in sorted({*verdict.failed, *verdict.undecided} ^ set(virtual.failed)):
            said = verdict.messages.get(check, "passes")
            print(f"      run {verdict.run}: {check}: {said}", flush=True)
    return not other, len(unsure)


def _page(verdicts: list[Verdict]) -> str:
    """Return all verdicts as a page of Markdown, references before mutants."""
    by_solution: dict[str, list[Verdict]] = {}
    for verdict in sorted(verdicts, key=lambda v: (v.tier, v.run)):
        by_solution.setdefault(verdict.solution, []).append(verdict)
    parts = [PAGE_HEAD]
    for kind, title in (("reference", "References"), ("mutant", "Mutants")):
        rows = [v for name, v in by_solution.items() if f"/{kind}/" in name and len(v) > 1]
        live = [verdict for virtual, *others in rows for verdict in others]
        loads = sorted(verdict.load for verdict in live)
        if not live:
            continue
        unsure = sum(bool(verdict.undecided) for verdict in live)
        same = sum(_same(row[0], v) for row in rows for v in row[1:])
        parts.append(
            f"\n## {title}\n\n{len(live)} gradings in real time of {len(rows)} solutions; load "
            f"{loads[0]:.1f} to {loads[-1]:.1f}, half of them above {loads[len(loads) // 2]:.1f}. "
            f"Judged as in virtual time: {same}. Not decided, because the machine stalled: "
            f"{unsure}.\n\n| solution | virtual time | real time | fails |\n|---|---|---|---|\n"
        )
        parts += [_row(row) for row in rows]
    return "".join(parts)


def _row(verdicts: list[Verdict]) -> str:
    virtual, *live = verdicts
    exercise, _, name = virtual.solution.split("/")
    fails = [", ".join(f"`{check}`" for check in virtual.failed)] if virtual.failed else []
    for verdict in live:
        if not verdict.undecided and not _same(virtual, verdict):
            others = ", ".join(f"`{check}`" for check in verdict.failed) or "nothing"
            fails.append(f"in real time: {others}")
    scores = ", ".join(f"{v.score}{'?' if v.undecided else ''}" for v in live)
    cells = (f"{exercise}: {name}", f"{virtual.score} of {virtual.most}", scores, "; ".join(fails))
    return f"| {' | '.join(cells)} |\n"


def _same(virtual: Verdict, live: Verdict) -> bool:
    return (live.score, live.failed, live.undecided) == (virtual.score, virtual.failed, ())


def _read(keep: Path | None) -> Iterable[Verdict]:
    if keep is None or not keep.exists():
        return []
    lines = keep.read_bytes().splitlines()
    return [msgspec.json.decode(line, type=Verdict) for line in lines]


def _add(keep: Path | None, verdict: Verdict) -> None:
    if keep is not None:
        with keep.open("ab") as file:
            file.write(msgspec.json.encode(verdict) + b"\n")


if __name__ == "__main__":
    sys.exit(main())
