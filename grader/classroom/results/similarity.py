"""Find submissions that are nearly the same: winnowing over Python's tokens.

Source: Schleimer, Wilkerson & Aiken, "Winnowing: Local Algorithms for Document Fingerprinting",
SIGMOD 2003, the method of MOSS. Names, the values of numbers and strings, comments and layout don't
count, so renaming changes nothing. A match is a reason to ask two people, never a proof.
"""

from __future__ import annotations

import hashlib
import io
import keyword
import tokenize
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, islice

NOISE = 12  # tokens of a k-gram: shorter matches are chance
WINDOW = 9  # k-grams: any match of NOISE + WINDOW - 1 = 20 tokens is found
MOST = 50_000  # tokens of a file that are compared; the longest program of the course has 1,323
LONGEST = 1_000  # [bytes] of a line that are compared: tokenize takes a line's length squared
SIMILAR = 0.7  # share of the smaller one's fingerprints; the course's own solutions share 0.3
FEW = 8  # fingerprints; a submission with fewer is too short to compare
COMMON = 10  # submissions at least; a fingerprint that more than half of them have is common

_LAYOUT = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.ENCODING, tokenize.ENDMARKER)
_WORDS = frozenset(keyword.kwlist)


@dataclass(frozen=True)
class Group:
    """Students whose files are nearly the same."""

    file: str
    students: tuple[str, ...]
    similarity: float  # 0 … 1, of the closest pair
    identical: bool  # all of them, but for names, comments and layout


def similar_groups(
    texts: Mapping[str, Mapping[str, bytes]], given: Mapping[str, bytes]
) -> list[Group]:
    """Return the groups of near-identical submissions to one exercise, the closest first.

    Parameters
    ----------
    texts
        The files by name, for each student.
    given
        The skeletons by name: their lines don't count as similar.
    """
    groups = []
    for file in sorted({name for files in texts.values() for name in files}):
        handed_out = fingerprints(tokens(given.get(file, b"")))
        words = {student: tokens(files[file]) for student, files in texts.items() if file in files}
        groups += _groups_of(file, words, handed_out)
    return sorted(groups, key=lambda group: (-group.similarity, group.file, group.students))


def tokens(source: bytes) -> list[str]:
    """Return a file's tokens without names and values; its words if it isn't Python."""
    found: list[str] = []
    lines = (line[:LONGEST] for line in io.BytesIO(source))
    try:
        for token in islice(tokenize.tokenize(lambda: next(lines, b"")), MOST):
            if token.type not in _LAYOUT:
                found.append(_word(token))
    except Exception:  # whatever a file makes tokenize raise: LookupError for "coding: rot13"
        return source.decode("utf-8", "replace").split()[:MOST]
    return found


def fingerprints(words: Sequence[str]) -> frozenset[int]:
    """Return the hashes that winnowing keeps: the smallest of each window."""
    grams = [_hash(words[i : i + NOISE]) for i in range(len(words) - NOISE + 1)]
    if len(grams) <= WINDOW:
        return frozenset(grams)
    windows = (grams[i : i + WINDOW] for i in range(len(grams) - WINDOW + 1))
    return frozenset(min(window) for window in windows)


def _word(token: tokenize.TokenInfo) -> str:
    if token.type == tokenize.NAME:
        return token.string if token.string in _WORDS else "name"
    if token.type in (tokenize.OP, tokenize.ERRORTOKEN):
        return token.string
    return tokenize.tok_name[token.type]  # NUMBER, STRING, INDENT, …


def _hash(words: Sequence[str]) -> int:
    digest = hashlib.blake2b("\0".join(words).encode("utf-8", "replace"), digest_size=8).digest()
    return int.from_bytes(digest, "big")


def _groups_of(
    file: str, words: Mapping[str, list[str]], handed_out: frozenset[int]
) -> list[Group]:
    own = {student: fingerprints(text) - handed_out for student, text in words.items()}
    holders = Counter(print_ for prints in own.values() for print_ in prints)
    most = max(COMMON, len(own)) / 2
    shared = frozenset(print_ for print_, n in holders.items() if n > most)
    links: dict[tuple[str, str], float] = {}
    for a, b in combinations(sorted(own), 2):
        if len(own[a]) < FEW or len(own[b]) < FEW:
            continue
        if words[a] == words[b]:
            links[a, b] = 1.0
            continue
        mine, theirs = own[a] - shared, own[b] - shared
        smaller = min(len(mine), len(theirs))
        alike = len(mine & theirs) / smaller if smaller >= FEW else 0.0
        if alike >= SIMILAR:
            links[a, b] = alike
    return [
        Group(
            file=file,
            students=tuple(sorted(members)),
            similarity=max(links[pair] for pair in links if pair[0] in members),
            identical=len({tuple(words[student]) for student in members}) == 1,
        )
        for members in _connected(links)
    ]


def _connected(links: Iterable[tuple[str, str]]) -> list[set[str]]:
    """Return the connected groups of the graph with these links."""
    near: dict[str, set[str]] = defaultdict(set)
    for a, b in links:
        near[a].add(b)
        near[b].add(a)
    groups, seen = [], set[str]()
    for start in sorted(near):
        if start in seen:
            continue
        group, edge = {start}, [start]
        while edge:
            for student in near[edge.pop()] - group:
                group.add(student)
                edge.append(student)
        seen |= group
        groups.append(group)
    return groups
