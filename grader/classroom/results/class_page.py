"""The class report, which the instructor reads first: one page, no script, no network."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from urllib.parse import quote

from grader.classroom.results.changes import changes
from grader.classroom.results.charts import sparkline
from grader.classroom.results.clean import folder_name, one_line
from grader.classroom.results.exercise_section import exercise_section, lost_section
from grader.classroom.results.items import Distribution, distribution
from grader.classroom.results.marks import (
    Task,
    is_absent,
    is_graded,
    is_held,
    is_provisional,
    points_of,
    so_far,
    why_held,
)
from grader.classroom.results.missing import Missing, Parts
from grader.classroom.results.options import Linked, ResultOptions
from grader.classroom.results.page import Element, document, el, name, section, table
from grader.classroom.results.sections import sections_of, sections_table
from grader.classroom.results.words import NOTHING, moment, plural, points
from grader.classroom.row import RUNNING, WAITING, StoredResult
from grader.report.page import GENERATED_BY

Results = Sequence[StoredResult]
Scores = Mapping[str, Distribution]  # by exercise


def class_page(
    results: Results,
    tasks: Sequence[Task],
    options: ResultOptions,
    absent: Sequence[Missing] = (),
    parts: Parts | None = None,
) -> str:
    """Return the report's HTML.

    Parameters
    ----------
    absent
        Other parts of the results that could not be made: the page names them.
    parts
        Notes the sections that can't be made; a sentence takes the place of each.
    """
    parts = parts or Parts()
    scores = {task.slug: _scores(results, task, parts) for task in tasks}
    held = [result for result in results if is_held(result)]
    return document(
        f"{options.title}: class report",
        parts.made(
            "the head of class.html",
            lambda: _top(results, held, tasks, options),
            lambda _: el("header", el("h1", "Class report"), class_="top"),
        ),
        el(
            "main",
            _absent(absent) if absent else None,
            None if options.anonymous else
            _section(parts, "held", "Held for you", lambda: _held(held, tasks)),
            _section(parts, "intake", "What was handed in", lambda: _intake(results, options)),
            _section(parts, "overview", "Overview", lambda: _overview(results, tasks, scores)),
            [
                exercise_section(_of(results, task), task, scores[task.slug], options, parts)
                for task in tasks
            ],
            _section(parts, "sections", "Sections",
                     lambda: sections_table(sections_of(results, options), tasks)),
            _section(parts, "students", "Students", lambda: _students(results, tasks, options)),
            _section(parts, "changes", "Changed marks", lambda: changes(options.log)),
            _section(parts, "notes", "Notes of the batch", lambda: _notes(results, options)),
        ),
        el(
            "footer",
            el("p", "Also in this folder: ", _joined(list(map(_linked, options.files))), ".")
            if options.files else None,
            el("p", f"Made by {GENERATED_BY}."),
            class_="foot",
        ),
    )  # fmt: skip


def _top(results: Results, held: Results, tasks: Sequence[Task], options: ResultOptions) -> Element:
    students = len({result.student for result in results})
    graded = sum(is_graded(result) for result in results)
    open_ = sum(result.state in (WAITING, RUNNING) for result in results)
    last = max((result.finished for result in results if result.finished), default="")
    facts = [
        plural(students, "student"),
        plural(len(tasks), "exercise"),
        plural(graded, "grading"),
        f"{len(held)} held" if held else None,
        f"{open_} not graded yet" if open_ else None,
        f"last graded {moment(last)}" if last else None,
    ]
    links = [("#overview", "Overview")]
    links += [(f"#exercise-{task.folder}", task.heading) for task in tasks]
    if sections_of(results, options):
        links.append(("#sections", "Sections"))
    links += [("#students", "Students"), ("#notes", "Notes")]
    if options.log:
        links.insert(-1, ("#changes", f"Changed marks ({len(options.log)})"))
    if held and not options.anonymous:
        links.insert(0, ("#held", f"Held ({len(held)})"))
    return el(
        "header",
        el("p", el("a", "Class report", href="../class.html"), " · section", class_="eyebrow")
        if options.section else el("p", "Class report", class_="eyebrow"),
        el("h1", el("bdi", one_line(options.section or options.title))),
        el("p", [el("span", fact) for fact in facts if fact], class_="facts-line"),
        el("nav", el("ul", [el("li", el("a", text, href=href)) for href, text in links]),
           aria_label="Sections"),
        class_="top",
    )  # fmt: skip


def bare_page(absent: Sequence[Missing]) -> str:
    """Return what takes the place of a report that could not be made at all."""
    return document("class report", el("main", _absent(absent)))


def _section(
    parts: Parts, id_: str, heading: str, make: Callable[[], Element | None]
) -> Element | None:
    """Return a section; if it can't be made, one that says so."""
    return parts.made(
        f"the section “{heading}” of class.html",
        make,
        lambda lost: lost_section(id_, heading, lost),
    )


def _scores(results: Results, task: Task, parts: Parts) -> Distribution:
    return parts.made(
        f"the distribution of scores of {task.heading}",
        lambda: distribution(_of(results, task), task),
        lambda _: distribution([], task),
    )


def _absent(absent: Sequence[Missing]) -> Element:
    return section(
        "missing",
        "Not all results could be written",
        "The grader failed in the parts below; everything else is complete, and no points are "
        "lost. Run the same command again. If a part stays away, report it with its line.",
        el("ul", [el("li", el("span", str(each), dir="auto")) for each in absent], class_="notes"),
        class_="is-held",
    )


# --- held for a person ---------------------------------------------------------------------


def _held(held: Results, tasks: Sequence[Task]) -> Element:
    if not held:
        return el(
            "p",
            el("strong", "Nothing is held. "),
            "Every grading that finished has a score.",
            class_="banner is-pass",
        )
    titles = {task.slug: task.heading for task in tasks}
    rows = []
    for result in held:
        why = why_held(result)
        rows.append(
            el("tr", el("th", name(result.student), scope="row"), el("td", titles[result.exercise]),
               el("td", el("span", why.reason, dir="auto", class_="said")),
               el("td", so_far(result) or NOTHING), el("td", why.action))
        )  # fmt: skip
    headings = [
        ("Student", ""), ("Exercise", ""), ("Why", "wide"), ("Points so far", ""),
        ("What to do", "wide"),
    ]  # fmt: skip
    return section(
        "held",
        "Held for you",
        "These have no score and are in no gradebook until you have looked at them. "
        "Nothing counts against the student.",
        table("Held gradings", headings, rows, stacks=True),
        class_="is-held",
    )


# --- what was handed in --------------------------------------------------------------------


def _intake(results: Results, options: ResultOptions) -> Element | None:
    """Say what became of the files, and who handed in nothing; None if nothing is known."""
    if not options.account.lines:
        return None
    counts = options.account.counts()
    faults = options.account.faults
    absent = sorted({result.student for result in results if is_absent(result)})
    here = {result.student for result in results if not is_absent(result)}
    nothing = [student for student in absent if student not in here]
    return section(
        "intake",
        "What was handed in",
        "Each file and entry, with what became of it, is in intake.csv.",
        el("p", "; ".join(f"{state}: {count}" for state, count in counts.items()), "."),
        el("ul", [el("li", el("span", one_line(line, 400), dir="auto")) for line in faults],
           class_="notes is-warn") if faults else None,
        el("p", f"{plural(len(nothing), 'student')} handed in nothing: ",
           _joined([[name(student, 48)] for student in nothing]), ".") if nothing else None,
    )  # fmt: skip


# --- all exercises -------------------------------------------------------------------------


def _overview(results: Results, tasks: Sequence[Task], scores: Scores) -> Element:
    rows = []
    for task in tasks:
        mine, spread = _of(results, task), scores[task.slug]
        ready = [(r.grading or {}).get("field_ready") for r in mine if is_graded(r)]
        asked = sum(value is not None for value in ready)
        rows.append(
            el(
                "tr",
                el("th", el("a", task.heading, href=f"#exercise-{task.folder}"), scope="row"),
                el("td", str(sum(is_graded(result) for result in mine)), class_="number"),
                el("td", str(sum(is_held(result) for result in mine)), class_="number"),
                el("td", str(sum(is_absent(result) for result in mine)), class_="number"),
                el("td", points(spread.median), class_="number"),
                el("td", points(spread.mean), class_="number"),
                el("td", str(spread.full), class_="number"),
                el("td", f"{sum(bool(v) for v in ready)} of {asked}" if asked else NOTHING,
                   class_="number"),
                el("td", sparkline(spread)),
            )
        )  # fmt: skip
    number = "number"
    headings = [
        ("Exercise", ""), ("Graded", number), ("Held", number),
        ("Not handed in", number), ("Median", number),
        ("Mean", number), ("Full marks", number), ("Field-ready", number), ("Scores", ""),
    ]  # fmt: skip
    return section("overview", "Overview", "", table("All exercises", headings, rows))


# --- students and notes --------------------------------------------------------------------


def _students(results: Results, tasks: Sequence[Task], options: ResultOptions) -> Element:
    found = {(result.student, result.exercise): result for result in results}
    rows = []
    for student in sorted({result.student for result in results}):
        folder = f"{options.root}feedback/{quote(folder_name(student))}"
        folder = "" if options.anonymous else folder
        mine = [(task, found.get((student, task.slug))) for task in tasks]
        counted = [points_of(result, task) for task, result in mine if result is not None]
        total = sum(points for points in counted if points is not None)
        rows.append(
            el(
                "tr",
                el(
                    "th",
                    _link(name(student, 48), folder, "index.html"),
                    _called(student, options),
                    scope="row",
                ),
                [_mark(result, task, folder) for task, result in mine],
                el("td", f"{total:g}", class_="number") if len(tasks) > 1 else None,
            )
        )
    headings = [("Student", "")]
    headings += [(task.heading if len(tasks) <= 4 else _short(task), "number") for task in tasks]
    if len(tasks) > 1:
        headings.append(("Points", "number"))
    return section(
        "students",
        "Students",
        "" if options.anonymous else "Each score links to the student's page.",
        table("Scores of all students", headings, rows),
    )


def _called(student: str, options: ResultOptions) -> Element | None:
    """Return the roster's name of a student, where it says more than the folder."""
    row = options.students.get(student)
    if options.anonymous or row is None or row.name in ("", student):
        return None
    return el("div", name(row.name, 60), class_="often")


def _mark(result: StoredResult | None, task: Task, folder: str) -> Element:
    if result is None:
        return el("td", NOTHING, class_="number quiet", title="nothing handed in")
    if is_absent(result):
        return el("td", NOTHING, class_="number quiet", title="nothing handed in")
    if is_held(result):
        held = el("a", "held", href="#held") if folder else "held"
        return el("td", held, class_="number is-warn")
    points = points_of(result, task)
    if not is_graded(result):
        return el("td", "open", class_="number quiet")
    if points is None:
        return el("td", "not counted", class_="number quiet")
    full = points >= task.points
    link = _link(f"{points:g}", folder, f"{quote(task.folder)}.html")
    word = "provisional" if is_provisional(result) else "changed" if result.amended else ""
    if word:
        told = " ".join(result.amended.steps) if result.amended else None
        return el("td", link, " ", el("small", word, title=told), class_="number")
    return el("td", link, class_="number is-pass" if full else "number")


def _link(what: Element | str, folder: str, page: str) -> Element | str:
    """Return a link into a folder; without one only its words."""
    return el("a", what, href=f"{folder}/{page}") if folder else what


def _short(task: Task) -> str:
    return f"Ex. {task.number}" if task.number else one_line(task.title, 16)


def _notes(results: Results, options: ResultOptions) -> Element:
    notes = [el("li", el("span", one_line(note, 600), dir="auto")) for note in options.notes]
    again = sum(result.attempts > 1 for result in results)
    if again:
        notes.append(el("li", f"{plural(again, 'grading')} took more than one attempt."))
    made = Counter(
        tuple(sorted((str(k), str(v)) for k, v in (result.grading.get("versions") or {}).items()))
        for result in results
        if result.grading is not None
    )
    if len(made) > 1:
        notes.append(
            el("li", "Gradings were made with different versions, listed below: scores may not be "
                     "comparable. Grade them all with one version.", class_="is-warn")
        )  # fmt: skip
    versions = [
        el("li", el("strong", plural(count, "grading")), ": ",
           ", ".join(f"{one_line(key)} {one_line(value)}" for key, value in each) or "unknown")
        for each, count in sorted(made.items(), key=lambda pair: (-pair[1], pair[0]))
    ]  # fmt: skip
    return section(
        "notes",
        "Notes of the batch",
        "" if notes else "There are no notes.",
        el("ul", notes, class_="notes") if notes else None,
        [el("h3", "Versions"), el("ul", versions, class_="notes")] if versions else None,
    )


def _linked(each: Linked) -> list[Element | str]:
    """Return a file's link, or a folder's name with the links of its files."""
    if each.paths == (each.name,):
        return [el("a", each.name, href=each.name), f" ({each.what})"]
    files = _joined([[el("a", path.removeprefix(each.name), href=path)] for path in each.paths])
    return [f"{each.name} ({each.what}: ", *files, ")"]


def _joined(parts: Sequence[list[Element | str]]) -> list[Element | str]:
    return [piece for i, part in enumerate(parts) for piece in ([", "] if i else []) + part]


def _of(results: Results, task: Task) -> list[StoredResult]:
    return [result for result in results if result.exercise == task.slug]
