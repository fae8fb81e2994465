"""A page for each check that somebody failed: who, how, and their replays, two side by side."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence

from grader.classroom.marks import Check, checks_of, judged_ones
from grader.classroom.results.items import Item, alike, item_analysis
from grader.classroom.results.options import ResultOptions
from grader.classroom.results.page import render
from grader.classroom.row import StoredResult
from grader.lms.book import Task

CHECKS = "checks"  # the folder

Groups = Sequence[Sequence[tuple[StoredResult, Check]]]  # by kind of failure


def page_of(task: Task, check: str) -> str:
    """Return where the page of a check is, seen from the class report."""
    return f"{CHECKS}/{task.slug}/{check}.html"


def check_pages(
    results: Sequence[StoredResult], tasks: Iterable[Task], options: ResultOptions
) -> Iterator[tuple[str, str]]:
    """Return the page of each check that somebody failed, and where it goes."""
    for task in tasks:
        judged = judged_ones([result for result in results if result.exercise == task.slug])
        for item in item_analysis(judged):
            if item.failed:
                yield page_of(task, item.id), _page(judged, task, item, options)


def _page(judged: Sequence[StoredResult], task: Task, item: Item, options: ResultOptions) -> str:
    kinds: dict[str, list[tuple[StoredResult, Check]]] = defaultdict(list)
    for result in judged:
        for check in checks_of(result):
            if check.get("id") == item.id and check.get("outcome") == "fail":
                kinds[alike(str(check.get("message") or ""))].append((result, check))
    groups = sorted(kinds.values(), key=lambda group: -len(group))
    return render(
        "check.html",
        f"{item.id}: {options.title}",
        frames=True,
        task=task,
        item=item,
        groups=groups,
        shown=_two(groups),
        replays=options.replays_in,
    )


def _two(groups: Groups) -> list[StoredResult]:
    """Return the first of each of the two most frequent kinds, else two of one kind."""
    with_replays = [[r for r, _ in group if r.recordings is not None] for group in groups]
    some = [group for group in with_replays if group]
    firsts = [group[0] for group in some]
    return (firsts if len(firsts) > 1 else [one for group in some for one in group])[:2]
