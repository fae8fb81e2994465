"""One exercise in the class report: scores, checks, slow gradings, similar submissions."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from grader.classroom.results.charts import failures, histogram
from grader.classroom.results.check_pages import page_of
from grader.classroom.results.clean import one_line
from grader.classroom.results.items import ENOUGH, Distribution, Item, item_analysis
from grader.classroom.results.marks import Task, is_graded
from grader.classroom.results.missing import Missing, Parts
from grader.classroom.results.options import ResultOptions
from grader.classroom.results.own_code import OwnCode
from grader.classroom.results.page import Element, el, name, section, table
from grader.classroom.results.similarity import Group
from grader.classroom.results.words import NOTHING, plural, points, seconds, signed
from grader.classroom.row import StoredResult, as_graded
from grader.course.exercises import EXERCISES

SLOWEST = 5
LOST = "The grader could not make this part ({}). The others are complete."
FEW = " With {} these figures are mostly chance, so they are not interpreted here."

Results = Sequence[StoredResult]


def exercise_section(
    results: Results, task: Task, scores: Distribution, options: ResultOptions, parts: Parts
) -> Element:
    """Return the section of the class report about one exercise; each part stands for itself."""
    graded = [result for result in results if is_graded(result)]
    judged = judged_ones(graded)
    if not graded:
        return section(f"exercise-{task.folder}", task.heading, "No grading counts yet.")

    def part(heading: str, make: Callable[[], Element | None]) -> Element | None:
        name = f"“{heading}” of {task.heading} in class.html"
        return parts.made(name, make, lambda lost: _lost_part(heading, lost))

    return section(
        f"exercise-{task.folder}",
        task.heading,
        "",
        el(
            "div",
            part("Scores", lambda: _scores(scores)),
            part("Slowest gradings", lambda: _slowest(graded, task)),
            class_="pair",
        ),
        part("Checks", lambda: _checks(item_analysis(judged), len(judged), task, options)),
        None
        if options.section
        else part("Nearly the same", lambda: _similar(results, options, task)),
    )


def judged_ones(graded: Results) -> list[StoredResult]:
    """Return what the judge said: a check that a person has waived is as hard as it was."""
    return [one for one in map(as_graded, graded) if is_graded(one)]


def lost_section(id_: str, heading: str, lost: Missing) -> Element:
    """Return what takes the place of a section that could not be made."""
    return section(id_, heading, LOST.format(lost.why), class_="is-held")


def _lost_part(heading: str, lost: Missing) -> Element:
    return el("div", el("h3", heading), el("p", LOST.format(lost.why), class_="is-warn"))


def _scores(scores: Distribution) -> Element:
    middle = scores.quartiles
    facts = [
        f"mean {points(scores.mean)}",
        f"middle half {middle[0]:g} to {middle[1]:g}" if middle else None,
        f"{scores.full} of {len(scores.scores)} with full marks",
    ]
    caption = " · ".join(fact for fact in facts if fact)
    return el(
        "figure",
        el("h3", "Scores"),
        histogram(scores),
        el("figcaption", caption),
        class_="card",
    )


def _slowest(graded: Results, task: Task) -> Element:
    slowest = sorted(graded, key=lambda result: (-result.wall_s, result.student))[:SLOWEST]
    rows = [
        el("tr", el("th", name(result.student, 40), scope="row"),
           el("td", seconds(result.wall_s), class_="number"),
           el("td", seconds(result.cpu_s), class_="number"),
           el("td", str(result.attempts), class_="number"))
        for result in slowest
    ]  # fmt: skip
    number = "number"
    headings = [("Student", ""), ("Wall", number), ("CPU", number), ("Attempts", number)]
    return el(
        "div",
        el("h3", "Slowest gradings"),
        table(f"Slowest gradings, {task.heading}", headings, rows, "is-plain"),
        class_="card",
    )


def _checks(items: Sequence[Item], submissions: int, task: Task, options: ResultOptions) -> Element:
    pages = {item.id: f"{options.root}{page_of(task, item.id)}" for item in items if item.failed}
    pages = {} if options.anonymous else pages
    headings = [
        ("Check", "wide"), ("Did not pass", ""), ("Difficulty", "number"),
        ("Discrimination", "number"), ("What it may mean", "hint"),
    ]  # fmt: skip
    bodies = []
    for kind, words in (("core", "Core"), ("field", "Field, no points")):
        group = [item for item in items if item.kind == kind]
        if group:
            group.sort(key=lambda item: -item.failed)  # stable: then in the checks' order
            head = el("tr", el("th", words, scope="rowgroup", colspan=len(headings)),
                      class_="group-row")  # fmt: skip
            bodies.append(
                el("tbody", head, [_check(item, submissions, pages.get(item.id)) for item in group])
            )
    return el(
        "div",
        el("h3", "Checks, the most failed first"),
        table(f"Checks, the most failed first, {task.heading}", headings, bodies, stacks=True),
        el(
            "p",
            "Difficulty is the share of submissions that pass: 0 is hardest. Discrimination is the "
            "point-biserial correlation between passing the check and the points of all the "
            "others: near 0 the check separates nobody; below 0, look at the check itself."
            + (" A check's title leads to the replays of those who failed it." if pages else "")
            + ("" if submissions >= ENOUGH else FEW.format(plural(submissions, "submission"))),
            class_="quiet",
        ),
    )


def _check(item: Item, submissions: int, page: str | None) -> Element:
    title = el("span", item.title, dir="auto")
    counts = [f"{item.failed} failed"] if item.failed else []
    counts += [f"{item.skipped} skipped"] if item.skipped else []
    heard = None
    if item.often:
        heard = el(
            "p",
            f"{item.times} times: ",
            el("span", item.often, dir="auto", class_="said"),
            class_="often",
        )
    return el(
        "tr",
        el("th", el("a", title, href=page) if page else title, el("code", one_line(item.id)), heard,
           scope="row"),
        el("td", failures(item, submissions),
           el("span", ", ".join(counts) or "none", class_="counts-word")),
        el("td", NOTHING if item.difficulty is None else f"{item.difficulty:.2f}", class_="number"),
        el("td", signed(item.discrimination), class_="number"),
        el("td", item.hint if submissions >= ENOUGH else NOTHING, class_="hint"),
    )  # fmt: skip


def _similar(results: Results, options: ResultOptions, task: Task) -> Element | None:
    texts = {
        result.student: options.sources[result.student, task.slug]
        for result in results
        if (result.student, task.slug) in options.sources
    }
    found = options.alikes.of(task.slug, texts, _skeletons(task))
    if found is None:
        return None
    groups = found.groups
    heading = el("h3", "Nearly the same")
    pasted = _own_code(found.own, task)
    if not groups:
        words = f"No two of {plural(len(texts), 'submission')} are nearly the same."
        return el("div", heading, el("p", words, class_="quiet"), pasted)
    return el(
        "div",
        heading,
        pasted,
        table(
            f"Groups of submissions that are nearly the same, {task.heading}",
            [("Students", "wide"), ("Similarity", "number"), ("File", "wide")],
            [_group(group) for group in groups],
            stacks=True,
        ),
        el(
            "p",
            "Names, comments, numbers and layout are ignored, and the skeleton is left out. "
            "Similarity is the share of the smaller file that the closest two have in common. "
            "It is a reason to ask, not a proof.",
            class_="quiet",
        ),
    )


def _own_code(found: Sequence[OwnCode], task: Task) -> Element | None:
    """Return the submissions that hold the course's own code."""
    if not found:
        return None
    rows = [
        el(
            "tr",
            el("th", name(match.student), scope="row"),
            el("td", f"{100 * match.similarity:.0f} %", class_="number"),
            el("td", el("code", one_line(match.file))),
            el("td", el("code", one_line(match.source))),
        )
        for match in found
    ]
    return el(
        "div",
        table(
            f"Submissions that hold the course's own code, {task.heading}",
            [("Student", "wide"), ("Similarity", "number"), ("File", "wide"), ("Course", "wide")],
            rows,
            stacks=True,
        ),
        el(
            "p",
            "Students can read the checks. A part of one pasted into a node wins its points; "
            "whether it is the student's work a person has to say.",
            class_="quiet",
        ),
    )


def _group(group: Group) -> Element:
    degree = f"{100 * group.similarity:.0f} %"
    word = (
        el("span", "identical but for names and layout", class_="tag") if group.identical else None
    )
    return el(
        "tr",
        el("th", el("ul", [el("li", name(student)) for student in group.students],
                    class_="people"), scope="row"),
        el("td", degree, class_="number"),
        el("td", el("code", one_line(group.file)), " " if word is not None else None, word),
    )  # fmt: skip


def _skeletons(task: Task) -> dict[str, bytes]:
    folder = EXERCISES / task.slug
    return {file.name: file.read_bytes() for file in sorted(folder.glob("*.py"))}
