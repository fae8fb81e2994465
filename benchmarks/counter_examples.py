"""How many wrong nodes does `course search` find without being told, and any right one?

The search runs over references, variants and mutants; in a right node that does not claim to be
field-ready without what only the badge asks for. Nothing found in a right node is the claim;
of the mutants only some can be found, since a search knows no more than what no right node does.
What is done already is read from `--keep FILE`, so an interrupted run goes on where it was. Ends
with 1 if something was found in a right node.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import msgspec

from grader.authoring.claims import Claim, claims, complete
from grader.cli.results import write_report
from grader.course.exercises import Exercise, find_exercise
from grader.drive.search import arena_of, search_node
from grader.errors import InputError
from grader.link.choice import start_launcher

RIGHT = ("reference", "variant")
SEARCHED = ("1", "2", "3", "4", "5", "7", "8", "9")


class Looked(msgspec.Struct, frozen=True):
    """A node that was searched."""

    solution: str
    program: str  # a digest of its files: another program is another claim
    seed: int
    most: int  # tries at most
    tries: int
    seconds: float
    kind: str = ""  # of the mishap; "" for none
    sentence: str = ""
    toml: str = ""


def main() -> int:
    """Search and print; 1 if something was found in a right node."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("exercises", nargs="*", help="all that drive by default")
    parser.add_argument("--right", type=int, default=2000, help="tries for each right node")
    parser.add_argument("--wrong", type=int, default=200, help="tries for each mutant")
    parser.add_argument("--variants", type=int, default=1000, help="of each exercise, at most")
    parser.add_argument("--mutants", type=int, default=1000, help="of each exercise, at most")
    parser.add_argument("--only", nargs="*", default=[], help="nodes of these names")
    parser.add_argument("--enough", type=int, default=1000, help="mutants found in each exercise")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, help="read and add what was found (JSON lines)")
    parser.add_argument("--worlds", action="store_true", help="print each world that was found")
    parser.add_argument("--reports", type=Path, help="write the replay of each find into a folder")
    options = parser.parse_args()
    known = read(options.keep)
    if options.reports is not None:
        options.reports.mkdir(parents=True, exist_ok=True)
    bad = 0
    for name in options.exercises or SEARCHED:
        exercise = find_exercise(name)
        rows = []
        every = list(claims(exercise))
        chosen = set(
            few(every, "variant", options.variants) + few(every, "mutant", options.mutants)
        )
        for claim in every:
            if claim.kind in ("variant", "mutant") and claim.name not in chosen:
                continue
            if options.only and claim.stem not in options.only:
                continue
            if sum(bool(row.kind) for one, row in rows if one.kind == "mutant") >= options.enough:
                break
            most = options.right if claim.kind in RIGHT else options.wrong
            if claim.kind == "skeleton" or claim.lacks or not most:
                continue
            row = known.get((claim.name, program_of(claim), options.seed, most))
            if row is None:
                row = look(claim, options.seed, most, options.reports)
                if options.keep is not None:
                    with options.keep.open("ab", buffering=0) as file:
                        file.write(msgspec.json.encode(row) + b"\n")
            rows.append((claim, row))
        for line in lines(exercise, rows, worlds=options.worlds):
            print(line, flush=True)
        bad += sum(claim.kind in RIGHT and bool(row.kind) for claim, row in rows)
    return 1 if bad else 0


def few(every: list[Claim], kind: str, most: int) -> list[str]:
    """Return the names of at most so many claims of a kind, from all over the list."""
    names = [claim.name for claim in every if claim.kind == kind and not claim.lacks]
    return [names[i * len(names) // most] for i in range(most)] if len(names) > most else names


def look(claim: Claim, seed: int, most: int, reports: Path | None = None) -> Looked:
    """Search in one node; write the replay of what is found."""
    field = claim.field_ready or claim.kind not in RIGHT
    began = time.perf_counter()
    kind = sentence = toml = ""
    tries = 0
    with start_launcher(claim.exercise.libraries) as launcher, complete(claim) as submission:
        try:
            result = search_node(
                arena_of(claim.exercise, field=field), submission, launcher, seed=seed, tries=most
            )
        except InputError as error:  # not in virtual time
            kind, sentence = "refused", str(error)
        else:
            tries = result.tries
            if result.found is not None:
                kind, sentence = result.found.mishap.kind, result.found.sentence
                toml = result.found.toml
                if reports is not None:
                    name = f"{claim.exercise.number}-{claim.stem}"
                    write_report(
                        reports / f"{name}.html", None, [result.found.recording],
                        f"{name}: {sentence}", opens_at=result.found.mishap.at,
                    )  # fmt: skip
    return Looked(
        solution=claim.name,
        program=program_of(claim),
        seed=seed,
        most=most,
        tries=tries,
        seconds=round(time.perf_counter() - began, 1),
        kind=kind,
        sentence=sentence,
        toml=toml,
    )


def program_of(claim: Claim) -> str:
    """Return a digest of a claim's files."""
    return hashlib.sha256(repr(sorted(claim.files.items())).encode()).hexdigest()[:16]


def read(keep: Path | None) -> dict[tuple[str, str, int, int], Looked]:
    """Return what was done already."""
    if keep is None or not keep.exists():
        return {}
    rows = [msgspec.json.decode(line, type=Looked) for line in keep.read_bytes().splitlines()]
    return {(row.solution, row.program, row.seed, row.most): row for row in rows}


def lines(exercise: Exercise, rows: list[tuple[Claim, Looked]], *, worlds: bool) -> Iterator[str]:
    """Return the table of an exercise."""
    yield f"\n{exercise.number} · {exercise.title}"
    for claim, row in rows:
        said = row.sentence or "nothing found"
        yield f"  {claim.kind:9} {claim.stem:36} {row.tries:5} tries {row.seconds:6.1f} s  {said}"
        if worlds and row.toml:
            yield "\n".join(f"      {line}" for line in row.toml.splitlines())
    right = [row for claim, row in rows if claim.kind in RIGHT]
    wrong = [row for claim, row in rows if claim.kind not in RIGHT]
    kinds = Counter(row.kind for row in wrong if row.kind)
    found = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common())
    yield (
        f"  right: {sum(bool(row.kind) for row in right)} of {len(right)} found; wrong: "
        f"{sum(kinds.values())} of {len(wrong)} found{f' ({found})' if found else ''}"
    )


if __name__ == "__main__":
    sys.exit(main())
