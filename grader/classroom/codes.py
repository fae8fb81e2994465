"""Codes in the place of students' names: the same each time, and made of a secret of this class."""

from __future__ import annotations

import hashlib
import secrets
from collections.abc import Iterable

from grader.classroom.store import Store

SECRET = "codes"  # what the store calls it
SHORT = 6  # [characters], as long as no two are equal


def codes_of(store: Store, students: Iterable[str]) -> dict[str, str]:
    """Return each student's code."""
    secret = store.kept(SECRET)
    if not secret:
        secret = secrets.token_hex(32)
        store.keep(SECRET, secret)
    digests = {s: hashlib.sha256(f"{secret}\0{s}".encode("utf-8", "replace")).hexdigest()
               for s in students}  # fmt: skip
    length = SHORT
    while len({digest[:length] for digest in digests.values()}) < len(digests):
        length += 1
    return {student: f"student-{digest[:length]}" for student, digest in digests.items()}
