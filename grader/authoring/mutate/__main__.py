"""Make mutants of right nodes by machine, grade them, and say which survive.

`python -m grader.authoring.mutate [EXERCISE …]` takes the reference of each exercise with every
single edit (`singles`), and the reference and two variants in every wrapper (`wrappers`). A mutant
is killed by the first check that it fails. One that fails none is *equivalent*, if the exercise's
`equivalents.toml` says so and why; otherwise it is a *gap*, and a gap needs a scenario or a check,
and a mutant written by hand that proves it.

Verdicts are kept in a file of JSON lines, and a run goes on where the last one ended. A verdict is
good for as long as the program, the checks, the scenarios and the simulator are what they were. A
survivor that could not be judged in full, since a library was missing, is judged again.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import sys
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from itertools import groupby
from pathlib import Path

import msgspec

from grader.authoring.claims import Claim, claims
from grader.authoring.gradings import gradings
from grader.authoring.mutate.equivalents import reviewed
from grader.authoring.mutate.singles import singles
from grader.authoring.mutate.wrappers import every
from grader.course.exercises import ROOT, Exercise, all_exercises, find_exercise
from grader.errors import InputError
from grader.grading.plugin import FAIL, UNJUDGED

KEEP = Path("build") / "mutate.jsonl"
VARIANTS = 2  # that are wrapped, beside the reference


class Verdict(msgspec.Struct, frozen=True):
    """What became of one mutant."""

    exercise: str
    name: str  # "EXERCISE says /cmd_vel linear.x LowPass 0.5"
    key: str  # of the program and of all that judged it
    killed_by: str  # a check; "" if none
    unsure: bool  # something could not be judged
    seconds: float


def mutants_of(exercise: Exercise, variants: int = VARIANTS) -> Iterator[Claim]:
    """Return every mutant of an exercise that can be graded here."""
    every_claim = [claim for claim in claims(exercise) if not claim.lacks]
    reference = next(claim for claim in every_claim if claim.kind == "reference")
    yield from singles(reference)
    yield from every(reference)
    others = [claim for claim in every_claim if claim.kind == "variant" and _all_nodes(claim)]
    for variant in others[:variants]:
        yield from every(variant)


def _all_nodes(claim: Claim) -> bool:
    """Return whether a variant's own files are nodes that can be wrapped, not a training script."""
    reference = {f: (claim.exercise.solutions / f).read_text("utf-8") for f in claim.files}
    own = [text for file, text in claim.files.items() if text != reference[file]]
    return all("rclpy" in text and "\nif __name__ == " in text for text in own)


def judge(every_mutant: Sequence[Claim], keep: Path, workers: int) -> Iterator[Verdict]:
    """Yield the verdict on each mutant: those that are kept, and those that are made now.

    The mutants of one right node come after those of another.
    """
    kept = list(_read(keep))
    known = {verdict.key: verdict for verdict in kept if verdict.killed_by or not verdict.unsure}
    suspects = {_change(verdict): verdict.killed_by for verdict in kept}
    keys = [_key(claim) for claim in every_mutant]
    yield from (known[key] for key in keys if key in known)
    left = [(c, key) for c, key in zip(every_mutant, keys, strict=True) if key not in known]
    keep.parent.mkdir(parents=True, exist_ok=True)
    with keep.open("ab", buffering=0) as file:
        for _, of_one_node in groupby(left, lambda pair: pair[0].stem.partition(" ")[0]):
            for verdict in _judge(list(of_one_node), suspects, workers):
                suspects[_change(verdict)] = verdict.killed_by
                file.write(msgspec.json.encode(verdict) + b"\n")
                yield verdict


def _judge(
    mutants: Sequence[tuple[Claim, str]], suspects: Mapping[tuple[str, str], str], workers: int
) -> Iterator[Verdict]:
    """Yield the verdicts on mutants of one node.

    `suspects`: the check that killed the same change in another node, or before.
    """
    claims_of = [claim for claim, _ in mutants]
    likely = [suspects.get((c.exercise.slug, c.stem.partition(" ")[2]), "") for c in claims_of]
    graded = gradings(claims_of, workers, first_failure=True, suspects=likely)
    begin = time.perf_counter()
    for (claim, key), grading in zip(mutants, graded, strict=True):
        end = time.perf_counter()
        failed = [check.id for check in grading.checks if check.outcome == FAIL]
        yield Verdict(
            exercise=claim.exercise.slug,
            name=claim.stem,
            key=key,
            killed_by=failed[0] if failed else "",
            unsure=any(check.outcome in UNJUDGED for check in grading.checks),
            seconds=end - begin,
        )
        begin = end


def _change(verdict: Verdict) -> tuple[str, str]:
    """Return what the name says that was done to a node, whichever it is."""
    return verdict.exercise, verdict.name.partition(" ")[2]


def _read(keep: Path) -> Iterator[Verdict]:
    if not keep.is_file():
        return
    for line in keep.read_bytes().splitlines():
        try:
            yield msgspec.json.decode(line, type=Verdict)
        except msgspec.MsgspecError:  # cut off in the middle: it is judged again
            continue


def _key(claim: Claim) -> str:
    """Return a digest of a program, and of the checks and scenarios by which it is judged."""
    digest = hashlib.sha256(_judges(claim.exercise).encode())
    for file, text in sorted(claim.files.items()):
        digest.update(f"{file}\n{text}\n".encode())
    return digest.hexdigest()


@cache
def _judges(exercise: Exercise) -> str:
    digest = hashlib.sha256()
    own = [path for path in exercise.judge.rglob("*") if path.suffix in (".py", ".toml")]
    shared = [*(ROOT / "grader" / "checks").glob("*.py"), *(ROOT / "sim").glob("*.py")]
    for path in sorted([*own, *shared]):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def summarise(exercise: Exercise, verdicts: Iterable[Verdict], *, whole: bool) -> list[str]:
    """Print an exercise's line of the table; return its gaps and, of a whole run, idle patterns."""
    judged = list(verdicts)
    list_ = reviewed(exercise)
    survivors = [verdict for verdict in judged if not verdict.killed_by]
    gaps = [verdict for verdict in survivors if not list_.reason(verdict.name)]
    killed = len(judged) - len(survivors)
    seconds = sum(verdict.seconds for verdict in judged)
    print(
        f"  {exercise.slug:20} {len(judged):9} {killed:6} {len(survivors) - len(gaps):10} "
        f"{len(gaps):4} {seconds:7.0f} s",
        flush=True,
    )
    unused = list_.unused([verdict.name for verdict in survivors]) if whole else []
    unsure = [verdict.name for verdict in survivors if verdict.unsure]
    return [
        *(f"{exercise.slug}: {verdict.name}: survives" for verdict in gaps),
        *(f"{exercise.slug}: {name}: could not be judged in full" for name in unsure),
        *(f"{exercise.slug}: equivalents.toml: {p!r} matches no survivor" for p in unused),
    ]


def main(arguments: list[str]) -> int:
    """Print the table; 1 if there are gaps."""
    parser = argparse.ArgumentParser(prog="mutate", description="Mutants made by machine.")
    parser.add_argument(
        "exercises", nargs="*", metavar="EXERCISE", help="name or number; all by default"
    )
    parser.add_argument("--only", metavar="WORDS", help="only mutants with this in their names")
    parser.add_argument("--variants", type=int, default=VARIANTS, help="that are wrapped, too")
    parser.add_argument("--survivors", action="store_true", help="only those that survived before")
    parser.add_argument("--list", action="store_true", help="list the mutants, grade none")
    parser.add_argument("--keep", type=Path, default=KEEP, help=f"verdicts; {KEEP} by default")
    cpus = len(os.sched_getaffinity(0))
    parser.add_argument("--workers", type=int, default=cpus, help=f"processes; {cpus} by default")
    options = parser.parse_args(arguments)
    try:
        exercises = [find_exercise(name) for name in options.exercises] or all_exercises()
    except InputError as error:
        parser.error(str(error))
    made = {exercise: list(mutants_of(exercise, options.variants)) for exercise in exercises}
    if options.only:
        made = {e: [m for m in found if options.only in m.stem] for e, found in made.items()}
    if options.survivors:
        lived = {(v.exercise, v.name) for v in _read(options.keep) if not v.killed_by}
        made = {
            e: [m for m in every_one if (e.slug, m.stem) in lived] for e, every_one in made.items()
        }
    if options.list:
        lines = [f"{exercise.slug}: {m.stem}" for exercise, found in made.items() for m in found]
        print("\n".join(lines))
        return 0
    print(f"  {'exercise':20} generated killed equivalent gaps      time")
    bad: list[str] = []
    whole = not options.only and options.variants >= VARIANTS
    for exercise, every_one in made.items():
        judged = judge(every_one, options.keep, options.workers)
        bad += summarise(exercise, judged, whole=whole)
    print(f"\n{len(bad)} to look at" + "".join(f"\n  {line}" for line in bad))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
