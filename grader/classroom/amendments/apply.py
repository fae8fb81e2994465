"""Apply the log to stored gradings: checks first, then lateness, a person's score last."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from msgspec.structs import replace as replace_struct

from grader.classroom.amendments import change as changes
from grader.classroom.amendments.late import lateness
from grader.classroom.amendments.log import Entry, style_words
from grader.classroom.amendments.marks import TO_HOLD, checks_of, points_of, task_of
from grader.classroom.row import ABSENT, GRADED, HELD, UNJUDGED, Amended, StoredResult
from grader.course.exercises import find_exercise
from grader.course.score import score_of
from grader.lms.book import StudentRow, about

SPARED = "Entry {} of the log changes nothing where it would lower a score (--may-lower)"


@dataclass(frozen=True)
class _Known:
    """What is known of the students, and what a person should know."""

    rows: Mapping[str, StudentRow]
    remarks: dict[str, list[str]] = field(default_factory=dict)  # a sentence: whom it is about

    def remark(self, text: str, student: str) -> None:
        self.remarks.setdefault(text, []).append(student)


def amended(
    results: Sequence[StoredResult], entries: Sequence[Entry], rows: Mapping[str, StudentRow]
) -> tuple[list[StoredResult], list[str]]:
    """Return the results as they count by the entries that do (`active`), and what to know of it.

    None of the given results is changed.
    """
    known = _Known(rows)
    entries = _of_this_class(entries, results, known)
    found = []
    for result in results:
        mine = [
            each for each in entries
            if isinstance(each.change, changes.Shown)
            and each.change.exercise == result.exercise
            and each.change.whom.includes(result.student, rows)
        ]  # fmt: skip
        found.append(_amended(result, mine, known) if mine else result)
    return found, [about(text, students) for text, students in known.remarks.items()]


def _of_this_class(
    entries: Sequence[Entry], results: Sequence[StoredResult], known: _Known
) -> list[Entry]:
    """Return the entries about the students as they are called now.

    A folder is somebody's for good. But what was nobody's goes to whom it is assigned.
    """
    here = {result.student for result in results}
    theirs = {
        entry.change.was: entry.change.whom.students[0]
        for entry in entries
        if isinstance(entry.change, changes.Assign) and len(entry.change.whom.students) == 1
    }
    found = []
    for entry in entries:
        change = entry.change
        if isinstance(change, changes.Undo) or here.issuperset(change.whom.students):
            found.append(entry)
            continue
        whom = change.whom
        now = {old: old if old in here else theirs.get(old, old) for old in whom.students}
        for gone in sorted(set(now.values()) - here):
            text = f"Entry {entry.number} of the log is about somebody who is not in the class"
            known.remark(text, gone)
        versions = {now[old]: hash_ for old, hash_ in whom.versions.items() if old in now}
        whom = replace_struct(whom, students=tuple(now.values()), versions=versions)
        found.append(replace(entry, change=replace_struct(change, whom=whom)))
    return found


def published(
    entries: Sequence[Entry], results: Sequence[StoredResult], rows: Mapping[str, StudentRow]
) -> set[tuple[str, str]] | None:
    """Return whose feedback is published, by student and exercise; None if nothing ever was."""
    entries = _of_this_class(entries, results, _Known(rows))
    wanted = [entry.change for entry in entries if isinstance(entry.change, changes.Publish)]
    if not wanted:
        return None
    return {
        one.key
        for one in results
        for change in wanted
        if one.exercise in (change.exercises or (one.exercise,))
        and change.whom.includes(one.student, rows)
    }


def _amended(result: StoredResult, entries: Sequence[Entry], known: _Known) -> StoredResult:
    task = task_of(result.exercise)
    steps: list[str] = []
    counted: list[Entry] = []
    changed = result
    for entry in entries:
        if isinstance(change := entry.change, changes.SetCheck | changes.Waive):
            said: list[str] = []
            after = _with_check(changed, change, said)
            if after is not None and not change.may_lower and _lowers(changed, after, result):
                known.remark(SPARED.format(entry.number), result.student)
                continue
            if after is not None:
                changed = after
                steps += said
                counted.append(entry)
                _note_version(entry, change.whom, result, known)
            elif change.whom.students:
                known.remark(
                    f"Entry {entry.number} of the log has no effect where {result.exercise} "
                    f"has no check {change.check}",
                    result.student,
                )
    if counted:
        changed = _judged(changed, result)
    points = points_of(changed)
    rules = [(entry, entry.change) for entry in entries if isinstance(entry.change, changes.Late)]
    if rules and points is not None:
        entry, rule = rules[-1]
        penalty = _penalty(rule, result, points, steps, known)
        counted += [entry] if penalty else []
        points = round(points - penalty, 2)
    scores = [(entry, entry.change) for entry in entries if isinstance(entry.change, changes.Score)]
    if scores:
        entry, given = scores[-1]
        points = min(given.points, task.points)
        steps = [f"Set by hand: {points:g} of {task.points:g} points."]
        counted = [entry]
        changed = replace(changed, state=GRADED)
        _note_version(entry, given.whom, result, known)
    words = _words(entries, result, known)
    if not counted and not words:
        return result
    numbers = tuple(entry.number for entry in (*counted, *(entry for entry, _ in words)))
    style = [entry.change for entry, _ in words if isinstance(entry.change, changes.Style)]
    amended_ = Amended(
        points, (*steps, *(said for _, said in words)), numbers, by_hand=bool(scores),
        graded=result, style=style[0].sums if style else None, only_words=not counted,
    )  # fmt: skip
    return replace(changed, amended=amended_)


def _words(
    entries: Sequence[Entry], result: StoredResult, known: _Known
) -> list[tuple[Entry, str]]:
    styles = [entry for entry in entries if isinstance(entry.change, changes.Style)]
    found = []
    for entry in entries:
        match entry.change:
            case changes.Comment() as told:
                found.append((entry, f"{told.file}, line {told.line}: {told.words}"))
                _note_version(entry, told.whom, result, known)
            case changes.Style() as told if entry is styles[-1]:
                found.append((entry, f"Beside these points: {style_words(told)}."))
                _note_version(entry, told.whom, result, known)
            case changes.Answer() as told:
                found.append((entry, f"Answer to your request: {told.words}"))
    return found


def _lowers(before: StoredResult, after: StoredResult, graded: StoredResult) -> bool:
    had, has = (points_of(_judged(each, graded)) for each in (before, after))
    return had is not None and has is not None and has < had


def _note_version(entry: Entry, whom: changes.Whom, result: StoredResult, known: _Known) -> None:
    """Remark that a mark was given for another submission than the one that is graded now."""
    then = whom.versions.get(result.student, "")
    if result.student in whom.students and then != version_of(result):
        made = "for an earlier submission" if then else "when nothing was handed in"
        known.remark(
            f"Entry {entry.number} of the log was made {made}, and still counts; look at it again",
            result.student,
        )


def version_of(result: StoredResult) -> str:
    """Return what tells one submission from another: the part of the hash that is of its files."""
    return "" if result.state == ABSENT else result.input_hash[:32]


# --- checks --------------------------------------------------------------------------------------


def _with_check(
    result: StoredResult, change: changes.SetCheck | changes.Waive, steps: list[str]
) -> StoredResult | None:
    """Return the result with one check changed; None if it has no such check."""
    grading = result.grading or {}
    checks = [dict(check) for check in checks_of(result)]
    check = next((check for check in checks if check.get("id") == change.check), None)
    if check is None:
        return None
    title = str(check.get("title") or change.check).rstrip(".")
    most, had = (float(check.get(key) or 0) for key in ("max_points", "points"))
    was = f"Before: {check.get('outcome')}, {had:g} of {most:g} points."
    said = str(check.get("message") or "")
    if isinstance(change, changes.Waive):
        check.update(outcome="skip", points=0, max_points=0, waived=True)
        check["message"] = f"Does not count. {was} {said}".strip()
        steps.append(f"“{title}” does not count.")
    else:
        points = min(change.points, most)
        check.update(points=points, outcome="pass" if points >= most else "fail")
        check["message"] = f"Set by hand to {points:g} of {most:g} points. {was} {said}".strip()
        steps.append(f"“{title}” was set to {points:g} of {most:g} points.")
    return replace(result, grading={**grading, "checks": checks})


def _judged(result: StoredResult, before: StoredResult) -> StoredResult:
    """Return the result with its sums made anew.

    What was held for checks that could not be judged is held no longer once a person has judged
    them all.
    """
    grading = result.grading or {}
    core = [check for check in checks_of(result) if check.get("kind") != "field"]
    sums = score_of(core, find_exercise(result.exercise).essential)
    new: dict[str, Any] = {
        **grading, "score": sums.points, "max_score": sums.most, "raw_score": sums.raw,
        "cap": sums.note,
    }  # fmt: skip
    if all(check.get("outcome") == "pass" or check.get("waived") for check in core):
        new["cause"] = None
    sure = all(check.get("outcome") not in TO_HOLD for check in checks_of(result))
    for_checks = UNJUDGED in before.problem and any(
        check.get("outcome") in TO_HOLD for check in checks_of(before)
    )
    if before.state == HELD and sure and for_checks:
        return replace(result, grading=new, state=GRADED, problem="")
    return replace(result, grading=new)


# --- lateness ------------------------------------------------------------------------------------


def _penalty(
    rule: changes.Late, result: StoredResult, points: float, steps: list[str], known: _Known
) -> float:
    task, row = task_of(result.exercise), known.rows.get(result.student)
    handed = row.handed.get(result.exercise) if row else None
    late, guess = lateness(rule, result.student, handed)
    if guess:
        known.remark(f"{task.heading}: {guess}", result.student)
    share = min(late * rule.per_day, rule.cap)
    penalty = round(min(points, task.points * share / 100), 2)
    if not penalty:
        return 0.0
    days = "1 day" if late == 1 else f"{late} days"
    steps.append(
        f"{days} late: {share:g} % of {task.points:g} points less, which leaves "
        f"{round(points - penalty, 2):g} of {points:g}."
    )
    return penalty
