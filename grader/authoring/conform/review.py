"""The reviewed list: which differences between plain Python and a host are meant, and why."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path

import msgspec

from grader.errors import InputError

LIST = Path(__file__).with_name("reviewed.toml")
ABSENT = "absent"  # a test that one of the two places does not have


class Entry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One reason, and the tests that differ for it."""

    tests: tuple[str, ...]  # patterns of names: * stands for anything
    reason: str
    plain: str = "passed"  # how they end in plain Python; "*": however
    inside: str = "failed"  # how they end in a host
    flaky: bool = False  # they differ in some runs only: real time has a hand in it


class Reviewed(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The reviewed list of one suite."""

    meant: tuple[Entry, ...] = ()


class Difference(msgspec.Struct, frozen=True):
    """A test that does not end in a host as it does in plain Python."""

    test: str
    plain: str
    inside: str
    text: str = ""  # why it failed

    def __str__(self) -> str:
        return f"{self.test}: plain {self.plain}, inside {self.inside}"


@dataclass
class Review:
    """What the list says about the differences that were found."""

    meant: list[tuple[Difference, Entry]] = field(default_factory=list)
    unlisted: list[Difference] = field(default_factory=list)
    stale: list[str] = field(default_factory=list)  # patterns whose tests no longer differ

    @property
    def passed(self) -> bool:
        """Everything that differs is meant, and all that is listed differs."""
        return not (self.unlisted or self.stale)


def read_list(suite: str, path: Path = LIST) -> Reviewed:
    """Read the part of the reviewed list that is about a suite.

    Raises
    ------
    InputError
        The file is not of this form; the message says where.
    """
    try:
        suites = msgspec.convert(tomllib.loads(path.read_text("utf-8")), dict[str, Reviewed])
    except (msgspec.ValidationError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"{path}: {error}") from error
    return suites.get(suite, Reviewed())


def differences(
    plain: dict[str, str], inside: dict[str, str], texts: dict[str, str]
) -> list[Difference]:
    """Return the tests that end in two ways, in order of their names."""
    ended = {
        test: (plain.get(test, ABSENT), inside.get(test, ABSENT))
        for test in sorted(plain.keys() | inside.keys())
    }
    return [Difference(t, a, b, texts.get(t, "")) for t, (a, b) in ended.items() if a != b]


def review(found: Iterable[Difference], ran: Iterable[str], reviewed: Reviewed) -> Review:
    """Compare the differences between two runs of the tests `ran` with the list."""
    result = Review()
    used: set[str] = set()
    for difference in found:
        entry, pattern = _find(difference, reviewed.meant)
        used.add(pattern)
        if entry is None:
            result.unlisted.append(difference)
        else:
            result.meant.append((difference, entry))
    names = list(ran)
    result.stale = [
        pattern
        for entry in reviewed.meant
        if not entry.flaky
        for pattern in entry.tests
        if pattern not in used and any(fnmatchcase(name, pattern) for name in names)
    ]
    return result


def _find(difference: Difference, entries: Iterable[Entry]) -> tuple[Entry | None, str]:
    for entry in entries:
        if entry.plain not in ("*", difference.plain) or entry.inside not in (
            "*",
            difference.inside,
        ):
            continue
        for pattern in entry.tests:
            if fnmatchcase(difference.test, pattern):
                return entry, pattern
    return None, ""
