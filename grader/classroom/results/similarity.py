"""Find submissions that are nearly the same, or hold the course's own code, by runs of tokens.

Names, the values of numbers and strings, comments and layout don't count, so renaming changes
nothing. A match is a reason to ask, never a proof.

Students have the checks, because their practice needs them. An oracle that is pasted into a node
passes local checks and the instructor's; it is not the student's work, which a person has to say.
"""

from __future__ import annotations

import contextlib
import io
import keyword
import re
import sys
import tokenize
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations, islice
from pathlib import Path, PurePosixPath
from typing import TypeAlias

import msgspec

from grader.course.exercises import (
    EXERCISES,
    JUDGE,
    ROOT,
    SOLUTIONS,
    all_exercises,
    find_exercise,
)
from grader.link.cell import Refused, read_in_cell

RUN = 20  # tokens: shorter matches are chance
MOST = 20_000  # tokens of a student that are compared; the longest program here has 1,323
LONGEST = 1_000  # [bytes] of a line that are compared: tokenize takes a line's length squared
SIMILAR = 0.7  # share of the smaller one's runs; the course's own solutions share at most 0.69
PASTED = 0.35  # share of a file that the checks hold, too; of right solutions at most 0.12
FEW = 40  # runs; a submission with fewer is too short to compare
COMMON = 10  # submissions at least; a run that more than half of them have is common
CHECKS = ROOT / "grader" / "checks"
SHARED = (ROOT / "grader" / "models" / "features.py", ROOT / "grader" / "recording" / "views.py")

# what `ros2 pkg create` writes, and what starts a package: everybody's are alike
MADE = re.compile(r"setup\.py|__init__\.py|test_\w+\.py|.*launch\.py")
_LAYOUT = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.ENCODING, tokenize.ENDMARKER)
_WORDS = frozenset(keyword.kwlist)

Texts: TypeAlias = Mapping[str, Mapping[str, bytes]]  # student: the files by name
Words: TypeAlias = Mapping[str, Mapping[str, list[str]]]  # student: the files' tokens by name
Prints: TypeAlias = frozenset[int]


class Group(msgspec.Struct, frozen=True):
    """Students whose files are nearly the same."""

    file: str
    students: tuple[str, ...]
    similarity: float  # 0 … 1, of the closest pair


class OwnCode(msgspec.Struct, frozen=True):
    """A submission that holds code of the course's."""

    student: str
    file: str
    source: str  # the course's file that most of it is in
    similarity: float  # 0 … 1, of the submission's own code


class Alike(msgspec.Struct, frozen=True):
    """What comparing the submissions to one exercise came to."""

    count: int  # submissions
    groups: tuple[Group, ...]
    own: tuple[OwnCode, ...]


def compared(sources: Mapping[tuple[str, str], Mapping[str, bytes]]) -> dict[str, Alike]:
    """Compare the submissions to each exercise: the files of (student, slug)."""
    found = {}
    for slug in sorted({slug for _, slug in sources}):
        texts = {
            student: parts_of(files, find_exercise(slug).files)
            for (student, each), files in sources.items()
            if each == slug
        }
        given = {file.name: file.read_bytes() for file in sorted((EXERCISES / slug).glob("*.py"))}
        words = words_of(texts)
        groups, own = similar_groups(words, given), own_code(words, given, slug)
        found[slug] = Alike(len(texts), tuple(groups), tuple(own))
    return found


def parts_of(files: Mapping[str, bytes], names: Sequence[str]) -> dict[str, bytes]:
    """Return what is compared of a submission: the exercise's files (`names`), its own modules.

    The first file counts with all modules that came along: where a node's parts lie, in which
    package, makes no difference. Other exercises' files are compared with theirs.
    """
    exercises = {name for exercise in all_exercises() for name in exercise.files}
    named = {PurePosixPath(place).name: files[place] for place in sorted(files)}
    parts = {name: named[name] for name in names if name in named}
    own = {n: text for n, text in named.items() if n not in exercises and not MADE.fullmatch(n)}
    if parts and own:
        first = next(iter(parts))
        parts[first] = b"\n".join([parts[first], *own.values()])
    return {**own, **parts}


def words_of(texts: Texts) -> dict[str, dict[str, list[str]]]:
    """Return the tokens of each student's files, in processes of their own.

    Files that can't be read so are compared with nobody's.
    """
    found = {}
    for student, files in texts.items():
        with contextlib.suppress(Refused):
            every = read_in_cell(tokens_of, list(files.values()), returns=list[list[str]])
            found[student] = {
                name: [sys.intern(word) for word in words]
                for name, words in zip(files, every, strict=True)
            }
    return found


def tokens_of(sources: Sequence[bytes]) -> list[list[str]]:
    """Return the tokens of several files, MOST of all together."""
    left, found = MOST, []
    for source in sources:
        found.append(tokens(source, left))
        left -= len(found[-1])
    return found


def similar_groups(words: Words, given: Mapping[str, bytes]) -> list[Group]:
    """Return the groups of near-identical submissions to one exercise, the closest first.

    The lines of what was `given`, the skeletons, don't count as similar.
    """
    groups = []
    for file in sorted({name for files in words.values() for name in files}):
        mine = {student: files[file] for student, files in words.items() if file in files}
        groups += _groups_of(file, mine, prints_of(given.get(file, b"")))
    return sorted(groups, key=lambda group: (-group.similarity, group.file, group.students))


def own_code(words: Words, given: Mapping[str, bytes], exercise: str) -> list[OwnCode]:
    """Return the submissions to an exercise that hold the course's code, the most first."""
    handed_out = Prints().union(*map(prints_of, given.values()))
    checks = _prints([*CHECKS.glob("*.py"), *(JUDGE / exercise).glob("*.py"), *SHARED], handed_out)
    solutions = _prints((SOLUTIONS / exercise).rglob("*.py"), handed_out)
    every = Prints().union(*checks.values())
    found = []
    for student, files in words.items():
        for file, text in files.items():
            own = _runs(text) - handed_out
            if len(own) < FEW:
                continue
            pasted = len(own & every) / len(own)
            if pasted >= PASTED:
                found.append(OwnCode(student, file, _most(own, checks), pasted))
            source = _most(own, solutions)
            copied = _shared(own, solutions.get(source, Prints()))
            if copied >= SIMILAR:
                found.append(OwnCode(student, file, source, copied))
    return sorted(found, key=lambda match: (-match.similarity, match.student, match.file))


def tokens(source: bytes, most: int = MOST) -> list[str]:
    """Return a file's tokens without names and values; its words if it isn't Python."""
    found: list[str] = []
    lines = (line[:LONGEST] for line in io.BytesIO(source))
    try:
        for token in islice(tokenize.tokenize(lambda: next(lines, b"")), most):
            if token.type not in _LAYOUT:
                found.append(_word(token))
    except Exception:  # whatever a file makes tokenize raise: LookupError for "coding: rot13"
        return source.decode("utf-8", "replace").split()[:most]
    return found


def prints_of(source: bytes) -> Prints:
    """Return the hashes of a file's runs of tokens; they differ between processes."""
    return _runs(tokens(source))


def _runs(words: Sequence[str]) -> Prints:
    return frozenset(hash(tuple(words[i : i + RUN])) for i in range(len(words) - RUN + 1))


def _word(token: tokenize.TokenInfo) -> str:
    if token.type == tokenize.NAME:
        return token.string if token.string in _WORDS else "name"
    if token.type in (tokenize.OP, tokenize.ERRORTOKEN):
        return token.string
    return tokenize.tok_name[token.type]  # NUMBER, STRING, INDENT, …


def _prints(files: Iterable[Path], handed_out: Prints) -> dict[str, Prints]:
    return {
        file.relative_to(ROOT).as_posix(): prints_of(file.read_bytes()) - handed_out
        for file in sorted(files)
    }


def _most(own: Prints, sources: Mapping[str, Prints]) -> str:
    return max(sources, key=lambda source: len(own & sources[source]), default="")


def _shared(mine: Prints, theirs: Prints) -> float:
    """Return the share of the smaller one that both have; 0 if it is too short."""
    smaller = min(len(mine), len(theirs))
    return len(mine & theirs) / smaller if smaller >= FEW else 0.0


def _groups_of(file: str, words: Mapping[str, list[str]], handed_out: Prints) -> list[Group]:
    own = {student: _runs(text) - handed_out for student, text in words.items()}
    holders = Counter(print_ for prints in own.values() for print_ in prints)
    most = max(COMMON, len(own)) / 2
    common = frozenset(print_ for print_, n in holders.items() if n > most)
    links: dict[tuple[str, str], float] = {}
    for a, b in combinations(sorted(s for s in own if len(own[s]) >= FEW), 2):
        alike = 1.0 if words[a] == words[b] else _shared(own[a] - common, own[b] - common)
        if alike >= SIMILAR:
            links[a, b] = alike
    return [
        Group(
            file=file,
            students=tuple(sorted(members)),
            similarity=max(links[pair] for pair in links if pair[0] in members),
        )
        for members in _connected(links)
    ]


def _connected(links: Iterable[tuple[str, str]]) -> list[set[str]]:
    """Return the connected groups of the graph with these links."""
    groups: dict[str, set[str]] = defaultdict(set)
    for pair in links:
        together = set(pair).union(*(groups[student] for student in pair))
        groups |= dict.fromkeys(together, together)
    return list({min(group): group for group in groups.values()}.values())
