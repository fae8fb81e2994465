"""Find the students that a person means: by folder, id, login, e-mail or name."""

import difflib
from collections.abc import Iterable, Mapping, Sequence

from grader.errors import InputError
from grader.lms.book import StudentRow
from grader.lms.clean import one_line
from grader.lms.people import folded

NEAR = 3  # names in an error


def find_student(word: str, students: Sequence[str], rows: Mapping[str, StudentRow]) -> str | None:
    """Return the student whom a word means; None if nobody or more than one can be meant."""
    if word in students:
        return word
    forms = _forms(word)
    for names in (_ids, _names):
        found = [s for s in students if forms.intersection(map(folded, names(s, rows.get(s))))]
        if found:
            return found[0] if len(found) == 1 else None
    return None


def the_student(word: str, students: Sequence[str], rows: Mapping[str, StudentRow]) -> str:
    """Return the student whom a word means.

    Raises InputError: nobody or more than one can be meant; the message names the nearest.
    """
    found = find_student(word, students, rows)
    if found is not None:
        return found
    called = {name: s for s in students for name in _names(s, rows.get(s))}
    names = {s: _names(s, rows.get(s)) for s in students}
    parts = set(_parts(word))
    near = [s for s in students if parts.intersection(_parts(" ".join(names[s])))]
    near = near or [called[n] for n in difflib.get_close_matches(word, called, NEAR, cutoff=0.5)]
    shown = [_told_apart(s, names[s], rows.get(s)) for s in dict.fromkeys(near)]
    near_ones = " or ".join(shown[:NEAR])
    hint = f"did you mean {near_ones}?" if shown else "scores.csv lists all students"
    raise InputError(f"expected one student of this class, not {one_line(word)!r}; {hint}")


def _told_apart(student: str, names: Sequence[str], row: StudentRow | None) -> str:
    """Return a student's folder, with the name, if it is another, and ids."""
    words = [*names[1:2], *sorted(set(_ids(student, row)) - {student})[:2]]
    return one_line(f"{student} ({', '.join(words)})" if words else student)


def _parts(name: str) -> list[str]:
    return folded(name.replace(",", " ")).split()


def nearest(word: str, known: Iterable[str], what: str) -> InputError:
    """Return the error for a word that nothing is called."""
    names = sorted(set(known))
    near = difflib.get_close_matches(word, names, n=NEAR, cutoff=0.4)
    listed = ", ".join(names[:20]) or "none"
    hint = f"did you mean {' or '.join(near)}?" if near else f"there are: {listed}"
    return InputError(f"unknown {what} {one_line(word)!r}; {hint}")


def _forms(word: str) -> set[str]:
    """Return the forms of a name for comparison; gradebooks sort them, as "Lee, Ann"."""
    last, comma, first = word.partition(",")
    return {folded(word), folded(f"{first} {last}")} if comma and first.strip() else {folded(word)}


def _ids(student: str, row: StudentRow | None) -> list[str]:
    if row is None:
        return []
    handed = [id_ for each in row.handed.values() for id_ in (each.id, each.email) if id_]
    return [*row.person.ids.values(), *row.person.participants, *handed]


def _names(student: str, row: StudentRow | None) -> list[str]:
    names = [student]
    if row is not None:
        names += [row.person.label, *(each.name for each in row.handed.values())]
    return [name for name in dict.fromkeys(names) if name]
