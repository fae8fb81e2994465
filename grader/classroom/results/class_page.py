"""The class report, which the instructor reads first: one page, no script, no network."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from grader.classroom.amendments import marks
from grader.classroom.amendments.log import described, undone_by
from grader.classroom.results.items import Distribution, Item, distribution, failures
from grader.classroom.results.options import ResultOptions
from grader.classroom.results.page import render
from grader.classroom.results.words import NOTHING, moment, plural
from grader.classroom.row import RUNNING, WAITING, StoredResult
from grader.lms.book import Task
from grader.lms.clean import one_line

MOST_CHANGES = 50  # of the log

Results = Sequence[StoredResult]


@dataclass(frozen=True)
class _Exercise:
    """One exercise in the report."""

    task: Task
    results: Results
    graded: Results
    scores: Distribution
    judged: int  # gradings that the items are of
    items: Sequence[Item]  # the most failed first
    ready: str  # how many are field-ready


def class_page(
    results: Results, tasks: Sequence[Task], options: ResultOptions, missing: Sequence[str] = ()
) -> str:
    """Return the report's HTML; `missing` are other parts of the results that could not be made."""
    held = [
        (one, marks.task_of(one.exercise), marks.why_held(one))
        for one in results
        if marks.is_held(one)
    ]
    undone = dict(undone_by(options.log))
    versions = _versions(results)
    return render(
        "class.html",
        f"{options.title}: class report",
        options=options,
        missing=missing,
        facts=_facts(results, tasks, len(held)),
        held=held,
        nothing=sorted(
            {r.student for r in results} - {r.student for r in results if not marks.is_absent(r)}
        ),
        exercises=[_exercise(results, task, options) for task in tasks],
        sections=_sections(results, tasks, options),
        tasks=tasks,
        students=list(_students(results, tasks, options)),
        changes=[
            (entry, described(entry.change), entry.number not in undone)
            for entry in options.log[: -MOST_CHANGES - 1 : -1]
        ],
        notes=options.notes,
        again=sum(result.attempts > 1 for result in results),
        mixed=len(versions) > 1,
        versions=versions,
    )


def _sections(
    results: Results, tasks: Sequence[Task], options: ResultOptions
) -> list[tuple[str, list[tuple[Task, Results, Distribution]]]]:
    """Return the results by section of the roster and by exercise; [] if it has no sections."""
    found: dict[str, list[StoredResult]] = {}
    for result in results:
        row = options.students.get(result.student)
        if row is not None and row.person.section:
            found.setdefault(row.person.section, []).append(result)
    by_task = {
        title: [(task, [r for r in mine if r.exercise == task.slug]) for task in tasks]
        for title, mine in sorted(found.items())
    }
    return [
        (title, [(task, theirs, distribution(theirs, task)) for task, theirs in each])
        for title, each in by_task.items()
    ]


def _facts(results: Results, tasks: Sequence[Task], held: int) -> list[str]:
    open_ = sum(result.state in (WAITING, RUNNING) for result in results)
    last = max((result.finished for result in results if result.finished), default="")
    facts = [
        plural(len({result.student for result in results}), "student"),
        plural(len(tasks), "exercise"),
        plural(sum(map(marks.is_graded, results)), "grading"),
        f"{held} held" if held else "",
        f"{open_} not graded yet" if open_ else "",
        f"last graded {moment(last)}" if last else "",
    ]
    return [fact for fact in facts if fact]


def _exercise(results: Results, task: Task, options: ResultOptions) -> _Exercise:
    mine = [result for result in results if result.exercise == task.slug]
    graded = [result for result in mine if marks.is_graded(result)]
    judged = marks.judged_ones(graded)
    ready = [(result.grading or {}).get("field_ready") for result in graded]
    asked = sum(value is not None for value in ready)
    return _Exercise(
        task,
        mine,
        graded,
        distribution(mine, task),
        len(judged),
        sorted(failures(judged), key=lambda item: -item.failed),
        f"{sum(map(bool, ready))} of {asked}" if asked else NOTHING,
    )


def _students(
    results: Results, tasks: Sequence[Task], options: ResultOptions
) -> Iterator[tuple[str, str, list[tuple[StoredResult | None, Task]], float]]:
    """Return each student with the roster's name, where it says more, the results and the sum."""
    found = {result.key: result for result in results}
    for student in sorted({result.student for result in results}):
        row = options.students.get(student)
        called = row.person.label if row is not None else ""
        called = "" if called == student else called
        mine = [(found.get((student, task.slug)), task) for task in tasks]
        points = [marks.points_of(result) for result, _ in mine if result is not None]
        yield student, called, mine, sum(each for each in points if each is not None)


def _versions(results: Results) -> list[tuple[str, int]]:
    """Return what the gradings were made with, and how many, the most first."""
    made = Counter(
        tuple(sorted((str(k), str(v)) for k, v in (result.grading.get("versions") or {}).items()))
        for result in results
        if result.grading is not None
    )
    return [
        (", ".join(f"{one_line(key)} {one_line(value)}" for key, value in each) or "unknown", count)
        for each, count in sorted(made.items(), key=lambda pair: (-pair[1], pair[0]))
    ]
