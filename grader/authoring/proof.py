"""Prove the graders: right solutions get full marks, wrong ones fail the checks that they name.

The wrong ones, *mutants*, are edits of right ones, listed in `mutants.diff` with at least one check
that has to catch each (see `grader.claims.mutants`). Other checks may fail with it. Field checks
are only judged when all of the core passed, so a mutant names either kind.

`python -m grader.authoring.proof [EXERCISE …]` prints which mutant is killed by which check;
`--only NAME` proves one, `--workers N` says how many processes grade, `--keep FILE` writes points,
failed checks and cause of each claim.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import msgspec

from grader.authoring.gradings import gradings
from grader.claims.claims import Claim, claims, grade_claim
from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.errors import GraderError, InputError
from grader.grading.grading import Grading
from grader.grading.plugin import FAIL, INCONCLUSIVE, UNAVAILABLE
from grader.launchers import fork_server
from grader.recording import noted_of
from grader.trial.kept import RECORDINGS, KeptRecordings

SKELETON_POINTS = 10  # at most


def objections(claim: Claim, grading: Grading) -> list[str]:
    """Return what the grading has against the claim; nothing if it holds."""
    failed = {check.id for check in grading.checks if check.outcome == FAIL}
    absent = unavailable(grading)
    found = [
        f"{check.id} is {check.outcome}: {check.message}"
        for check in grading.checks
        if check.outcome in ("error", "inconclusive")
    ]
    if claim.kind == "mutant":
        missed = claim.fails - failed - set(absent)
        found += [f"should fail {check}, and does not" for check in sorted(missed)]
    elif claim.kind == "skeleton":
        if grading.score > SKELETON_POINTS:
            found.append(f"gets {grading.score} points, at most {SKELETON_POINTS} are allowed")
    else:
        most = grading.exercise.max_points - sum(absent.values())
        if grading.score != most:
            found.append(f"gets {grading.score} of {most}: fails {failed}")
        if claim.field_ready and grading.field_ready is False:
            found.append(f"claims to be field-ready and fails {sorted(failed)}")
    if claim.kind == "reference":
        found += [
            f"is told: in {recording.name}, {said}"
            for recording in grading.recordings
            for said in noted_of(recording, models=False)
        ]
        ends = [each.ending for each in grading.recordings if each.ending]
        found += [f"after Ctrl-C {end.problem}" for end in ends if end.problem]
    return found


def unavailable(grading: Grading) -> dict[str, int]:
    """Return the checks, with their points, whose libraries are not installed on this machine."""
    return {c.id: c.max_points for c in grading.checks if c.outcome == UNAVAILABLE}


def unproven(claim: Claim, grading: Grading) -> str:
    """Say what of the claim could not be proven for lack of libraries; empty if all was."""
    absent = unavailable(grading)
    if claim.kind == "mutant":
        return ", ".join(sorted(claim.fails & set(absent)))
    return f"{sum(absent.values())} points" if absent and claim.kind != "skeleton" else ""


class Row(msgspec.Struct, frozen=True):
    """A claim, and what its grading came to."""

    exercise: str
    kind: str  # reference, variant, mutant or skeleton
    name: str
    mistake: str
    points: int
    most: int  # that could be won on this machine
    fails: tuple[str, ...]  # ids of checks
    cause: str  # the line above the table; "" if there is none

    @classmethod
    def of(cls, kind: str, name: str, mistake: str, grading: Grading) -> Row:
        """Return the row of a graded claim."""
        return cls(
            grading.exercise.slug,
            kind,
            name,
            mistake,
            grading.score,
            grading.max_score,
            tuple(sorted(check.id for check in grading.checks if check.outcome == FAIL)),
            "" if grading.cause is None else grading.cause.text,
        )


@dataclass
class Tally:
    """What the proof of one exercise came to."""

    slug: str
    mutants: int = 0
    killed: int = 0
    in_part: int = 0  # claims that could not be proven in full for lack of libraries
    uncaught: list[str] = field(default_factory=list)  # mutants that don't fail as they say
    unneeded: list[str] = field(default_factory=list)  # checks that no mutant fails
    other: list[str] = field(default_factory=list)  # objections to right solutions and skeletons
    stalled: list[Claim] = field(default_factory=list)  # the machine stalled while it was judged
    rows: dict[str, Row] = field(default_factory=dict)  # by the claim's name

    @property
    def objections(self) -> list[str]:
        """All that is wrong."""
        return self.uncaught + self.unneeded + self.other


def main(arguments: list[str]) -> int:
    """Print the table of the exercises named (all by default); 1 if anything is wrong."""
    parser = argparse.ArgumentParser(prog="proof", description="Prove the graders.")
    parser.add_argument(
        "exercises", nargs="*", metavar="EXERCISE", help="name or number; all by default"
    )
    parser.add_argument("--only", metavar="NAME", help="prove one solution or mutant")
    cpus = len(os.sched_getaffinity(0))
    parser.add_argument("--workers", type=int, default=cpus, help=f"processes; {cpus} by default")
    parser.add_argument(
        "--recordings", type=Path, default=RECORDINGS, metavar="FOLDER", help=f"{RECORDINGS}"
    )
    parser.add_argument(
        "--recorded-by", default="", metavar="ENGINE", help="judge what another engine recorded"
    )
    parser.add_argument("--keep", type=Path, metavar="FILE", help="write each claim's result there")
    options = parser.parse_args(arguments)
    kept = KeptRecordings(options.recordings, options.recorded_by)
    kept.tidy()
    try:
        exercises = [find_exercise(name) for name in options.exercises] or all_exercises()
        if options.only:
            return _prove_one(options.only, exercises, kept)
        everything = {exercise: list(claims(exercise)) for exercise in exercises}
    except (InputError, GraderError) as error:
        parser.exit(2, f"proof: {error}\n")
    if options.workers < 1:
        parser.error(f"--workers {options.workers}: expected at least 1")
    provable = [claim for each in everything.values() for claim in each if not claim.lacks]
    graded = gradings(provable, options.workers, kept=kept)
    tallies = [_prove(exercise, each, graded) for exercise, each in everything.items()]
    for tally in tallies:
        _prove_stalled(tally, kept.anew())
    print(f"\n  {'exercise':24} killed  of")
    for tally in tallies:
        rest = f"  ({tally.in_part} claims not proven in full here)" if tally.in_part else ""
        print(f"  {tally.slug:24} {tally.killed:6} {tally.mutants:3}{rest}")
    killed, mutants = sum(t.killed for t in tallies), sum(t.mutants for t in tallies)
    print(f"  {'together':24} {killed:6} {mutants:3}")
    rows = [row for tally in tallies for row in tally.rows.values()]
    if options.keep:
        keep(options.keep, rows)
    _print_list("Mutants that do not fail as they say", [x for t in tallies for x in t.uncaught])
    _print_list("Checks that no mutant needs", [x for t in tallies for x in t.unneeded])
    bad = [line for tally in tallies for line in tally.objections]
    print(f"\n{len(bad)} objections" + "".join(f"\n  {line}" for line in bad))
    return 1 if bad else 0


def _prove_one(name: str, exercises: list[Exercise], kept: KeptRecordings) -> int:
    """Prove the solutions and mutants of this name; 1 if anything is said against them."""
    chosen = [claim for exercise in exercises for claim in claims(exercise) if claim.stem == name]
    if not chosen:
        raise InputError(f"no solution or mutant is called {name!r} in these exercises")
    bad = 0
    for claim in chosen:
        with fork_server(libraries=claim.exercise.libraries) as forkserver:
            grading = grade_claim(claim, forkserver, kept=kept)
        failed = sorted(check.id for check in grading.checks if check.outcome == FAIL)
        print(f"{claim.name}: {grading.score} points; fails {', '.join(failed) or 'nothing'}")
        against = objections(claim, grading)
        print("".join(f"  ! {line}\n" for line in against), end="")
        bad += bool(against)
    return 1 if bad else 0


def _print_list(title: str, lines: list[str]) -> None:
    print(f"\n{title}: {'none' if not lines else len(lines)}")
    print("".join(f"  {line}\n" for line in lines), end="")


def keep(path: Path, rows: Iterable[Row]) -> None:
    """Write rows as JSON, one a line."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"".join(msgspec.json.encode(row) + b"\n" for row in rows))


def _prove(exercise: Exercise, claimed: list[Claim], graded: Iterator[Grading]) -> Tally:
    """Print a line for each claim; `graded` has the gradings of those that can be proven here."""
    tally = Tally(exercise.slug)
    used: set[str] = set()
    judged: set[str] = set()
    reasons: dict[str, None] = {}  # why checks can't be judged here
    for claim in claimed:
        tally.mutants += claim.kind == "mutant"
        if claim.lacks:
            tally.in_part += 1
            reasons[claim.lacks] = None
            print(f"~ {claim.name:64}   -  not proven here", flush=True)
            continue
        grading = next(graded)
        against = _against(claim, grading)
        tally.rows[claim.name] = Row.of(claim.kind, claim.stem, claim.about, grading)
        absent = unavailable(grading)
        if any(check.outcome == INCONCLUSIVE for check in grading.checks):
            tally.stalled.append(claim)
        judged |= {check.id for check in grading.checks if check.id not in absent}
        reasons |= {check.message: None for check in grading.checks if check.id in absent}
        by = sorted(check.id for check in grading.checks if check.outcome == FAIL)
        if claim.kind == "mutant":
            tally.killed += bool(by)
            tally.uncaught += against
            used |= set(by)
        else:
            tally.other += against
        badge = {True: "field-ready", False: "", None: ""}[grading.field_ready]
        said = ", ".join(by) if claim.kind == "mutant" else badge
        if lacking := unproven(claim, grading):
            tally.in_part += 1
            said += f"{'; ' if said else ''}not proven here: {lacking}"
        mark = "!" if against else "~" if lacking else " "
        print(f"{mark} {claim.name:64} {grading.score:3}  {said}", flush=True)
    print(f"{exercise.slug}: {tally.killed} of {tally.mutants} mutants killed")
    if tally.in_part:
        print(f"{exercise.slug}: {tally.in_part} claims (~) could not be proven in full")
        print("".join(f"  {reason}\n" for reason in reasons), end="")
    tally.unneeded = [f"{exercise.slug}: {check}" for check in sorted(judged - used)]
    return tally


def _prove_stalled(tally: Tally, kept: KeptRecordings) -> None:
    """Judge again, with nothing beside it, what could not be judged on a busy machine."""
    for claim in tally.stalled:
        (grading,) = gradings([claim], workers=1, kept=kept)
        against = _against(claim, grading)
        tally.rows[claim.name] = Row.of(claim.kind, claim.stem, claim.about, grading)
        print(f"{'!' if against else ' '} {claim.name:64} {grading.score:3}  judged again, alone")
        lines = tally.uncaught if claim.kind == "mutant" else tally.other
        lines[:] = [x for x in lines if not x.startswith(f"{claim.name}: ")] + against
        by = {f"{tally.slug}: {check.id}" for check in grading.checks if check.outcome == FAIL}
        tally.unneeded = [line for line in tally.unneeded if line not in by]


def _against(claim: Claim, grading: Grading) -> list[str]:
    return [f"{claim.name}: {line}" for line in objections(claim, grading)]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
