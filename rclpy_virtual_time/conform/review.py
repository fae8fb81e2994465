"""The reviewed list: which differences between plain Python and a host are meant, and why."""

import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import msgspec

from rclpy_virtual_time.link.errors import EngineError

LIST = Path(__file__).with_name("reviewed.toml")
ABSENT = "absent"  # a test that one of the two places does not have


class Entry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One reason, and the tests that differ for it."""

    tests: tuple[str, ...]
    reason: str
    inside: tuple[str, ...] = ("failed",)  # how they may end in a host; plain, they pass


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
    stale: list[str] = field(default_factory=list)  # listed tests that no longer differ
    late: list[str] = field(default_factory=list)  # fail in plain Python only: real time came late

    @property
    def passed(self) -> bool:
        """Everything that differs is meant, and all that is listed differs."""
        return not (self.unlisted or self.stale)


def read_list(suite: str, path: Path = LIST) -> Reviewed:
    """Read the part of the reviewed list that is about a suite.

    Raises EngineError: the file is not of this form; the message says where.
    """
    try:
        suites = msgspec.convert(tomllib.loads(path.read_text("utf-8")), dict[str, Reviewed])
    except (msgspec.ValidationError, tomllib.TOMLDecodeError) as error:
        raise EngineError(f"{path}: {error}") from error
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
    entries = {test: entry for entry in reviewed.meant for test in entry.tests}
    found = list(found)
    for difference in found:
        entry = entries.get(difference.test)
        if (difference.plain, difference.inside) == ("failed", "passed"):
            result.late.append(difference.test)
        elif entry and difference.plain == "passed" and difference.inside in entry.inside:
            result.meant.append((difference, entry))
        else:
            result.unlisted.append(difference)
    same = set(ran) - {difference.test for difference in found}
    result.stale = [test for test in entries if test in same]
    return result
