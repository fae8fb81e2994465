"""The class report's charts as SVG: coloured by the page's style, labelled for screen readers."""

from __future__ import annotations

from collections.abc import Sequence

from grader.classroom.results.items import BINS, Distribution, Item
from grader.classroom.results.page import Element, el
from grader.classroom.results.words import plural

WIDTH, HEIGHT = 440, 190  # [user units] of the histogram
LEFT, RIGHT, TOP, BOTTOM = 8, 8, 34, 34
GAP = 4


def histogram(scores: Distribution) -> Element:
    """Return the histogram of scores, a bar for each tenth of the points."""
    inner = WIDTH - LEFT - RIGHT
    high = HEIGHT - TOP - BOTTOM
    step = inner / BINS
    most = max(*scores.bins, 1)
    base = HEIGHT - BOTTOM
    marks: list[Element] = [
        el("line", x1=LEFT, x2=WIDTH - RIGHT, y1=base + 0.5, y2=base + 0.5, class_="axis")
    ]
    counts: list[Element] = []
    for index, count in enumerate(scores.bins):
        x = LEFT + index * step
        if count:
            top = base - max(3.0, high * count / most)
            marks.append(
                el("rect", x=_n(x + GAP / 2), y=_n(top), width=_n(step - GAP),
                   height=_n(base - top), rx=3, class_="column")
            )  # fmt: skip
            counts.append(el("text", str(count), x=_n(x + step / 2), y=_n(top - 6), class_="count"))
    for tenth in range(0, BINS + 1, 2):
        marks.append(
            el("text", f"{scores.points * tenth / BINS:g}", x=_n(LEFT + tenth * step),
               y=base + 16, class_=_anchor(tenth))
        )  # fmt: skip
    marks.append(el("text", "points", x=WIDTH / 2, y=HEIGHT - 3, class_="tick middle"))
    marks += _median(scores, inner) + counts  # the numbers on top of the median's line
    label = f"Histogram of {plural(len(scores.scores), 'score')}: {_in_words(scores)}"
    return _svg(WIDTH, HEIGHT, "histogram", label, marks)


def sparkline(scores: Distribution) -> Element:
    """Return the same histogram, small and without text."""
    width, height = 90, 22
    step = width / BINS
    most = max(*scores.bins, 1)
    marks = [el("line", x1=0, x2=width, y1=height - 0.5, y2=height - 0.5, class_="axis")]
    for index, count in enumerate(scores.bins):
        if count:
            tall = max(2.0, (height - 2) * count / most)
            marks.append(
                el("rect", x=_n(index * step + 0.75), y=_n(height - tall), width=_n(step - 1.5),
                   height=_n(tall), class_="column")
            )  # fmt: skip
    return _svg(width, height, "sparkline", f"Scores by tenths: {_in_words(scores)}", marks)


def failures(item: Item, of: int) -> Element:
    """Return a bar of how many of `of` submissions failed the check, and how many skipped it."""
    width, height = 100, 10
    failed = width * item.failed / of if of else 0.0
    skipped = width * item.skipped / of if of else 0.0
    marks = [el("rect", x=0, y=0, width=width, height=height, rx=2, class_="track")]
    if failed:
        marks.append(el("rect", x=0, y=0, width=_n(failed), height=height, rx=2, class_="failed"))
    if skipped:
        marks.append(
            el("rect", x=_n(failed), y=0, width=_n(skipped), height=height, class_="skipped")
        )
    label = f"{item.failed} of {of} failed, {item.skipped} skipped"
    return _svg(width, height, "failures", label, marks)


def _median(scores: Distribution, inner: float) -> list[Element]:
    if scores.median is None or len(scores.scores) < 2:
        return []
    x = LEFT + inner * scores.median / scores.points
    side = "end" if x > WIDTH * 0.6 else "start"
    away = -5 if side == "end" else 5
    return [
        el("line", x1=_n(x), x2=_n(x), y1=14, y2=HEIGHT - BOTTOM, class_="median"),
        el("text", f"median {scores.median:g}", x=_n(x + away), y=11, class_=f"median-word {side}"),
    ]


def _svg(width: float, height: float, class_: str, label: str, marks: Sequence[Element]) -> Element:
    box = f"0 0 {width} {height}"
    # the name of the attribute is case-sensitive
    svg = el("svg", marks, width=width, height=height, role="img", aria_label=label, class_=class_)
    svg.set("viewBox", box)
    return svg


def _in_words(scores: Distribution) -> str:
    tenth = scores.points / BINS
    parts = [
        f"{count} from {index * tenth:g} to {(index + 1) * tenth:g}"
        for index, count in enumerate(scores.bins)
        if count
    ]
    return ", ".join(parts) or "none"


def _anchor(tenth: int) -> str:
    return "tick start" if tenth == 0 else "tick end" if tenth == BINS else "tick middle"


def _n(value: float) -> str:
    return f"{value:.2f}".rstrip("0").rstrip(".")
