"""The class page and the scores with codes for students, to show to others.

A code is made of the student and a secret of this class, so it stays, and tells nothing. Left out
is what may name somebody: ids, sections, times, notes, what was handed in and the log.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from msgspec.structs import replace as copied

from grader.classroom.account import Account
from grader.classroom.codes import codes_of
from grader.classroom.folder import alike_of
from grader.classroom.marking import Marking
from grader.classroom.results.similarity import Alike
from grader.classroom.results.write import write_pages
from grader.classroom.row import StoredResult
from grader.errors import InputError


def write_anonymous(class_: Marking, into: Path) -> list[Path]:
    """Write class.html and scores.csv; return them.

    Raises InputError: the folder is that of the class, or lies in it.
    """
    if into.resolve().is_relative_to(class_.out.resolve()):
        raise InputError(f"--into {into}: expected a folder outside {class_.out}, to hand on")
    codes = codes_of(class_.store, class_.students)
    results = [_coded(result, codes) for result in class_.counting()]
    results.sort(key=lambda result: result.student)
    options = replace(
        class_.options,
        notes=[],
        students={},
        account=Account(),
        anonymous=True,
        alike=_alike_coded(alike_of(class_.store), codes),
    )
    into.mkdir(parents=True, exist_ok=True)
    return write_pages(results, into, options)


def _coded(result: StoredResult, codes: Mapping[str, str]) -> StoredResult:
    changed = result.amended
    if changed is not None:
        changed = replace(changed, graded=_coded(changed.graded, codes))
    code = codes[result.student]
    return replace(result, student=code, problem="", recordings=None, finished="", amended=changed)


def _alike_coded(known: Mapping[str, Alike], codes: Mapping[str, str]) -> dict[str, Alike]:
    """Return the groups of nearly the same submissions without names."""
    found = {}
    for slug, each in known.items():
        coded = [tuple(sorted(codes.get(s, "") for s in group.students)) for group in each.groups]
        groups = tuple(map(lambda g, names: copied(g, students=names), each.groups, coded))
        own = tuple(copied(match, student=codes.get(match.student, "")) for match in each.own)
        found[slug] = Alike(each.count, groups, own)
    return found
