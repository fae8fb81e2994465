"""The class page and the scores with codes for students, to show to others.

A code is made of the student and a secret of this class, so it stays, and tells nothing. Left out
is what may name somebody: ids, sections, times, notes, what was handed in, who is alike, the log.
"""

from __future__ import annotations

import hashlib
import hmac
import secrets
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from grader.classroom.account import Account
from grader.classroom.results import ResultOptions
from grader.classroom.results.write import write_pages
from grader.classroom.row import StoredResult
from grader.classroom.store import Store

SECRET = "codes"  # what the store calls it
LENGTH = 10  # [characters] of a code


def codes_of(store: Store, students: Iterable[str]) -> dict[str, str]:
    """Return each student's code, the same each time."""
    if not store.kept(SECRET):
        store.keep(SECRET, secrets.token_hex(32))
    key = store.kept(SECRET).encode()
    digests = {
        student: hmac.new(key, student.encode("utf-8", "replace"), hashlib.sha256).hexdigest()
        for student in students
    }
    return {student: f"student-{digest[:LENGTH]}" for student, digest in digests.items()}


def write_anonymous(
    results: Iterable[StoredResult], codes: Mapping[str, str], options: ResultOptions, into: Path
) -> list[Path]:
    """Write class.html and scores.csv; return them."""
    shown = sorted((_coded(one, codes) for one in results), key=lambda one: one.student)
    options = replace(options, notes=[], students={}, account=Account(), anonymous=True)
    into.mkdir(parents=True, exist_ok=True)
    return write_pages(shown, into, options)


def _coded(result: StoredResult, codes: Mapping[str, str]) -> StoredResult:
    changed = result.amended
    if changed is not None:
        changed = replace(changed, graded=_coded(changed.graded, codes))
    code = codes[result.student]
    return replace(result, student=code, problem="", recordings=None, finished="", amended=changed)
