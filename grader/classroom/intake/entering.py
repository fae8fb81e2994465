"""Enter a class into its store: queue what is new or changed, and lose nothing without a word."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from grader.classroom.account import Account, Fate
from grader.classroom.amendments.change import Accept, Assign
from grader.classroom.amendments.log import active
from grader.classroom.intake.candidates import Class, find_class
from grader.classroom.intake.whose import Known
from grader.classroom.options import Options
from grader.classroom.queue.candidate import Candidate
from grader.classroom.queue.conditions import HASHED
from grader.classroom.queue.store import Key, Store
from grader.classroom.results.options import OPTIONS, kept_options
from grader.classroom.row import ABSENT, HELD, StoredResult
from grader.errors import InputError
from grader.lms.book import StudentRow, named
from grader.lms.people import NO_PERSON

MOST_NAMED = 5  # students in a sentence


def known_of(store: Store) -> Known:
    """Return what a class's store knows of its students, and what people have said of them."""
    assigned: dict[str, tuple[str, ...]] = {}
    accepted: dict[Key, str] = {}
    for change in (entry.change for entry in active(store.entries())):
        if isinstance(change, Assign):
            assigned.update(dict.fromkeys(change.entries, change.whom.students))
        elif isinstance(change, Accept):
            accepted.update({(each, change.exercise): change.file for each in change.whom.students})
    return Known(store.students(), assigned, accepted)


def enter_candidates(
    submissions: Sequence[Path], scratch: Path, store: Store, options: Options, *, regrade: bool
) -> Class:
    """Find everybody's files and queue what is new or changed.

    A changed grader counts as a change too, except where recordings are to be judged again.

    Raises InputError: nobody handed in a file of any exercise, or `submissions` can't be read; or
    somebody who was graded is not in them, and nothing is said of that.
    """
    known = known_of(store)
    found = find_class(submissions, scratch, options, known)
    slugs = {slug for _, slug in found.candidates}
    stored = {result.key: result for result in store.results()}
    moved = {  # all that they had handed in is assigned to others by now
        student for student, row in known.rows.items()
        if row.seen and all(student not in known.assigned.get(word, (student,))
                            for word in row.seen)
    }  # fmt: skip
    gone = {
        key: result
        for key, result in stored.items()
        if key[1] in slugs and key[0] not in moved
        and (key not in found.candidates or found.candidates[key].absent)
    }  # fmt: skip
    lost = {key for key, result in gone.items() if result.grading is not None}
    if lost and not (options.add or options.drop):
        raise InputError(_lost(lost, stored, found.candidates, submissions))
    seen = {word for row in found.students for word in row.seen}
    held = {key for key, result in gone.items()
            if result.state == HELD and key[0] in known.rows
            and seen.isdisjoint(known.rows[key[0]].seen)}  # fmt: skip
    kept = frozenset(lost | held if options.add else ())
    texts = {}
    for key, candidate in found.candidates.items():
        if key in kept:
            continue
        files, problem = candidate.read()
        texts[key] = candidate.shown()
        store.enter(
            key,
            candidate.input_hash(files, options),
            problem=problem,
            absent=candidate.absent,
            compared=HASHED if regrade else None,
        )
    store.keep_texts(texts)
    store.keep_only({*found.candidates, *kept}, slugs)
    said = ""
    if options.add and kept:
        said = f"Kept as they were, since they are not in these downloads: {_some(kept)}."
    elif lost:
        said = (
            f"Earlier results were dropped, because nothing of them is there: {_some(lost)}. A run "
            "with all downloads of the class grades them again."
        )
        store.note(said)
    store.know(_known_rows(found.students, known, kept))
    account = found.account
    if options.add:
        text = store.kept(OPTIONS)
        earlier = kept_options(text, {}).account.lines if text else ()
        new = {line.student for line in account.lines if line.state != Fate.NOTHING}
        away = {student for student, _ in kept} - new
        lines = [line for line in earlier if line.student in away]
        account = Account((*lines, *(each for each in account.lines if each.student not in away)))
    return replace(found, said=said, kept=kept, account=account)


def _known_rows(
    rows: Sequence[StudentRow], known: Known, kept: Collection[Key]
) -> Iterator[StudentRow]:
    """Return what is known of students now, with what earlier downloads told."""
    for row in rows:
        old = known.rows.get(row.student, row)
        handed = {slug: each for slug, each in old.handed.items() if (row.student, slug) in kept}
        yield replace(
            row,
            person=old.person if row.person == NO_PERSON else row.person,
            handed={**handed, **row.handed},
            seen=tuple(sorted({*old.seen, *row.seen})),
        )


def _lost(
    lost: Collection[Key], stored: Mapping[Key, StoredResult], candidates: Mapping[Key, Candidate],
    submissions: Sequence[Path],
) -> str:  # fmt: skip
    """Return the refusal to forget who was graded."""
    where = ", ".join(map(str, submissions))
    before = {student for (student, _), result in stored.items() if result.state != ABSENT}
    here = [key for key, each in candidates.items() if not each.absent]
    if not any(student in before for student, _ in here):
        return (
            f"expected the class that was graded here: of its {len(before)} students "
            f"({named(sorted(before), MOST_NAMED)}) nobody is in {where} ({_some(here)}); give "
            "another --out for another class, or --add to put these beside it"
        )
    return (
        f"{where}: nothing in it is of {len({student for student, _ in lost})} whose work is "
        f"graded: {_some(lost)}. Give all downloads of the class together; or --add, and they stay "
        "as they are; or --drop, and their results are forgotten"
    )


def _some(keys: Iterable[Key]) -> str:
    return named(sorted({student for student, _ in keys}), MOST_NAMED)
