"""Which submissions are nearly the same, remembered: to compare 500 takes a while, marks change."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path

import msgspec

from grader.classroom.results.files import write_text
from grader.classroom.results.own_code import OwnCode, own_code
from grader.classroom.results.similarity import Group, similar_groups

Texts = Mapping[str, Mapping[str, bytes]]  # by student: the files by name


class Alike(msgspec.Struct, frozen=True):
    """What comparing the submissions to one exercise came to."""

    made_of: str  # a hash of all that was compared
    count: int  # submissions
    groups: tuple[Group, ...]
    own: tuple[OwnCode, ...]


class Alikes:
    """Compares submissions; what was compared before is read from a file."""

    def __init__(self, file: Path | None = None) -> None:
        self._file = file
        self._known: dict[str, Alike] = {}
        if file is not None:
            try:
                self._known = msgspec.json.decode(file.read_bytes(), type=dict[str, Alike])
            except (OSError, msgspec.MsgspecError, ValueError):
                self._known = {}

    @classmethod
    def known(cls, found: Mapping[str, Alike]) -> Alikes:
        """Return what others have found."""
        made = cls()
        made._known = dict(found)
        return made

    def all(self) -> Mapping[str, Alike]:
        """Return what is known of every exercise."""
        return self._known

    def of(self, slug: str, texts: Texts, skeletons: Mapping[str, bytes]) -> Alike | None:
        """Return what is known of an exercise; without texts what was found the last time."""
        before = self._known.get(slug)
        if not texts:
            return before
        made_of = _digest({**texts, "": skeletons})
        if before is None or before.made_of != made_of:
            before = Alike(
                made_of,
                len(texts),
                tuple(similar_groups(texts, skeletons)),
                tuple(own_code(texts, skeletons, slug)),
            )
            self._known[slug] = before
        return before

    def save(self) -> None:
        """Remember what was found."""
        if self._file is not None and self._known:
            write_text(self._file, msgspec.json.encode(self._known).decode())


def _digest(texts: Texts) -> str:
    digest = hashlib.sha256()
    for student in sorted(texts):
        files = texts[student].items()
        hashes = sorted((name, hashlib.sha256(text).hexdigest()) for name, text in files)
        digest.update(json.dumps([student, hashes]).encode())
    return digest.hexdigest()
