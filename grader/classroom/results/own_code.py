"""Find submissions that hold the course's own code: a check's oracle pasted in, a solution copied.

Students have the checks, because their practice needs them. An oracle that is pasted into a node
passes local checks and the instructor's; it is not the student's work, which a person has to say.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from grader.classroom.results.similarity import FEW, SIMILAR, fingerprints, tokens
from grader.course.exercises import JUDGE, ROOT, SOLUTIONS

PASTED = 0.35  # share of a file that the checks hold, too; of right solutions at most 0.19
CHECKS = ROOT / "grader" / "checks"
SHARED = (ROOT / "grader" / "models" / "features.py", ROOT / "grader" / "recording" / "views.py")


@dataclass(frozen=True)
class OwnCode:
    """A submission that holds code of the course's."""

    student: str
    file: str
    source: str  # the course's file that most of it is in
    similarity: float  # 0 … 1, of the submission's own code


def own_code(
    texts: Mapping[str, Mapping[str, bytes]], given: Mapping[str, bytes], exercise: str
) -> list[OwnCode]:
    """Return the submissions to an exercise that hold the course's code, the most first.

    Parameters
    ----------
    texts
        The files by name, for each student.
    given
        The skeletons by name: their lines don't count.
    exercise
        Slug of the exercise.
    """
    handed_out = frozenset[int]().union(*(fingerprints(tokens(text)) for text in given.values()))
    checks = _prints(_checks(exercise), handed_out)
    solutions = _prints((SOLUTIONS / exercise).rglob("*.py"), handed_out)
    found = []
    for student, files in texts.items():
        for file, text in files.items():
            own = fingerprints(tokens(text)) - handed_out
            if len(own) < FEW:
                continue
            found += [
                OwnCode(student, file, source, share)
                for source, share in (_pasted(own, checks), _copied(own, solutions))
                if source
            ]
    return sorted(found, key=lambda match: (-match.similarity, match.student, match.file))


def _pasted(own: frozenset[int], checks: Mapping[str, frozenset[int]]) -> tuple[str, float]:
    """Return which of the checks' files is in a file most, and their share of it together."""
    together = frozenset[int]().union(*checks.values())
    share = len(own & together) / len(own)
    return _most(own, checks) if share >= PASTED else "", share


def _copied(own: frozenset[int], solutions: Mapping[str, frozenset[int]]) -> tuple[str, float]:
    """Return the solution that a file is nearly the same as, and how much so."""
    source = _most(own, solutions)
    theirs = solutions.get(source, frozenset())
    smaller = min(len(own), len(theirs))
    share = len(own & theirs) / smaller if smaller >= FEW else 0.0
    return source if share >= SIMILAR else "", share


def _most(own: frozenset[int], sources: Mapping[str, frozenset[int]]) -> str:
    return max(sources, key=lambda source: len(own & sources[source]), default="")


def _checks(exercise: str) -> Iterator[Path]:
    yield from sorted(CHECKS.glob("*.py"))
    yield from sorted((JUDGE / exercise).glob("*.py"))
    yield from SHARED


def _prints(files: Iterator[Path], handed_out: frozenset[int]) -> dict[str, frozenset[int]]:
    return {
        file.relative_to(ROOT).as_posix(): fingerprints(tokens(file.read_bytes())) - handed_out
        for file in sorted(files)
    }
