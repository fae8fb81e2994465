"""A page for each check that somebody failed: who, how, and their replays, two side by side."""

from __future__ import annotations

import shutil
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from urllib.parse import quote

from grader.classroom.results.clean import folder_name, one_line
from grader.classroom.results.files import write_text
from grader.classroom.results.items import Item, alike, item_analysis
from grader.classroom.results.marks import Check, Task, checks_of
from grader.classroom.results.missing import Parts
from grader.classroom.results.page import Element, document, el, name, section, table
from grader.classroom.results.words import NOTHING, plural, signed
from grader.classroom.row import StoredResult

CHECKS = "checks"  # the folder
SIDES = ("left", "right")

Results = Sequence[StoredResult]
Groups = Sequence[Sequence[tuple[StoredResult, Check]]]  # by kind of failure


def page_of(task: Task, check: str) -> str:
    """Return where the page of a check is, seen from the class report."""
    return f"{CHECKS}/{task.folder}/{folder_name(check)}.html"


def write_check_pages(
    judged: dict[str, list[StoredResult]],
    tasks: Sequence[Task],
    out: Path,
    replays: str,
    title: str,
    parts: Parts,
) -> list[Path]:
    """Write the pages anew.

    Parameters
    ----------
    judged
        Results as the judge made them, by exercise.
    replays
        The folder of the pages whose replays are shown.
    """
    shutil.rmtree(out / CHECKS, ignore_errors=True)
    written = []
    for task in tasks:
        for item in item_analysis(judged.get(task.slug, [])):
            if not item.failed:
                continue
            with parts.part(f"the page of the check {item.id} of {task.heading}"):
                text = _page(judged[task.slug], task, item, replays, title)
                written.append(write_text(out / page_of(task, item.id), text))
    return written


def _page(judged: Results, task: Task, item: Item, replays: str, title: str) -> str:
    failed = [
        (result, check)
        for result in judged
        for check in checks_of(result)
        if check.get("id") == item.id and check.get("outcome") == "fail"
    ]
    kinds: dict[str, list[tuple[StoredResult, Check]]] = defaultdict(list)
    for result, check in failed:
        kinds[alike(str(check.get("message") or ""))].append((result, check))
    groups = sorted(kinds.values(), key=lambda group: -len(group))
    shown = _two(groups)
    facts = [
        f"{item.failed} of {item.judged} failed" if item.judged else f"{item.failed} failed",
        f"{item.skipped} skipped" if item.skipped else None,
        f"difficulty {NOTHING if item.difficulty is None else f'{item.difficulty:.2f}'}",
        f"discrimination {signed(item.discrimination)}",
    ]
    return document(
        f"{item.id}: {title}",
        el(
            "header",
            el("p", el("a", "Class report", href=f"../../class.html#exercise-{task.folder}"),
               f" · {task.heading}", class_="eyebrow"),
            el("h1", el("span", item.title, dir="auto")),
            el("p", [el("span", fact) for fact in facts if fact], class_="facts-line"),
            class_="top",
        ),
        el("main", section("who", *_replays(shown, task, item, replays),
                           *_who(groups, task, item, replays))),
        frames=True,
    )  # fmt: skip


def _two(groups: Groups) -> list[StoredResult]:
    """Return who is shown first: of the two most frequent kinds, else two of one kind."""
    with_replays = [[r for r, _ in group if r.recordings is not None] for group in groups]
    some = [group for group in with_replays if group]
    firsts = [group[0] for group in some]
    return (firsts if len(firsts) > 1 else [one for group in some for one in group])[:2]


def _replays(
    shown: Sequence[StoredResult], task: Task, item: Item, replays: str
) -> tuple[str, str, Element | None]:
    """Return the section's heading and first words, and the frames."""
    if not shown:
        return "Who failed it", "There are no recordings to replay.", None
    frames = [
        el(
            "iframe",
            src=_source(result, task, item, replays),
            title=f"Replay on the {side}",
            name=side,
            loading="lazy",
        )
        for side, result in zip(SIDES, shown, strict=False)
    ]
    words = "The replay opens where this check failed."
    if len(shown) > 1:
        words = "Each replay opens where this check failed; below, choose others for each side."
    return "Side by side", words, el("div", frames, class_="frames")


def _who(groups: Groups, task: Task, item: Item, replays: str) -> tuple[Element, Element]:
    bodies = []
    for group in groups:
        said = one_line(group[0][1].get("message") or "no message", 300)
        head = el(
            "tr",
            el("th", f"{plural(len(group), 'time')}: ", el("span", said, dir="auto"),
               scope="rowgroup", colspan=4),
            class_="group-row",
        )  # fmt: skip
        bodies.append(el("tbody", head, [_row(r, c, task, item, replays) for r, c in group]))
    headings = [("Student", ""), ("Expected", ""), ("Actual", "wide"), ("Replay", "")]
    return (
        el("h3", "By what was said, the most frequent first"),
        table("Who failed it", headings, bodies, stacks=True),
    )


def _row(result: StoredResult, check: Check, task: Task, item: Item, replays: str) -> Element:
    there = result.recordings is not None
    links: list[Element | str] = []
    for side in SIDES if there else ():
        links += [" "] if links else []
        links.append(
            el("a", side, href=_source(result, task, item, replays), target=side,
               aria_label=f"{one_line(result.student, 40)} on the {side}")
        )  # fmt: skip
    page = f"../../feedback/{quote(folder_name(result.student))}/{quote(task.folder)}.html"
    return el(
        "tr",
        el("th", el("a", name(result.student, 48), href=page), scope="row"),
        el("td", el("span", one_line(check.get("expected") or "", 120), dir="auto")),
        el("td", el("span", one_line(check.get("actual") or "", 200), dir="auto", class_="said")),
        el("td", links or NOTHING, class_="sides"),
    )


def _source(result: StoredResult, task: Task, item: Item, replays: str) -> str:
    student = quote(folder_name(result.student))
    return f"../../{replays}/{student}/{quote(task.folder)}.html#check={quote(item.id)}"
