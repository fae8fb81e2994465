"""How a node takes delays, as a table for the terminal and a page with two plots."""

from __future__ import annotations

from html import escape

from grader.checks.contract import Survived
from grader.drive.delay import AXES, DELAYS, SENSORS, Delays, Tried

BAR = 20  # [characters]
WIDTH, HEIGHT, GAP, LEFT, BOTTOM, TOP = 640, 220, 6, 46, 34, 16  # [px]
NAMES = {SENSORS: "scans and odometry", "commands": "commands"}
STYLE = """
:root { color-scheme: light dark; --bar: #2463b0; --bad: #b3261e; --line: #767676; }
@media (prefers-color-scheme: dark) { :root { --bar: #7fb2ee; --bad: #ff8a80; } }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 44rem; margin: 2rem auto; padding: 0 1rem; }
svg { width: 100%; height: auto; font: 12px system-ui, sans-serif; }
svg text { fill: currentColor; } .bar { fill: var(--bar); } .bad { fill: var(--bad); }
.reference { stroke: var(--line); stroke-dasharray: 4 3; }
table { border-collapse: collapse; } td, th { padding: 0.1rem 0.8rem 0.1rem 0; text-align: left; }
td:nth-child(-n+2) { text-align: right; }
"""


def table(result: Delays, reference: Survived | None) -> list[str]:
    """Return the lines for the terminal: a bar for each delay, and the numbers."""
    most = _most(result)
    lines = []
    for axis in AXES:
        lines += [
            f"Late {NAMES[axis]}",
            *(_line(one, most, result.unit) for one in _rows(result, axis)),
            "",
        ]
    return [*lines, *(said(result.survived, reference, axis) for axis in AXES)]


def said(survived: Survived, reference: Survived | None, axis: str) -> str:
    """Say in a sentence what the node survives, and what the reference does."""
    beside = f" (the reference: {_amount(reference.of(axis))})" if reference else ""
    if survived.of(axis) < 0:
        return f"Survives no late {NAMES[axis]}{beside}: it fails without any delay."
    return f"Survives {NAMES[axis]} that are late by {_amount(survived.of(axis))}{beside}."


def page(result: Delays, reference: Survived | None, file: str) -> str:
    """Return an HTML page with a plot and a table of each kind of delay."""
    title = escape(f"Delays: {file}, exercise {result.exercise.number}")
    parts = []
    for axis in AXES:
        number = escape(said(result.survived, reference, axis))
        parts.append(
            f"<h2>Late {NAMES[axis]}</h2>\n<p>{number}</p>\n{_plot(result, reference, axis)}"
        )
        parts.append(_html_table(result, axis))
    body = "\n".join(parts)
    return (
        f'<!doctype html>\n<html lang="en">\n<head><meta charset="utf-8"><title>{title}</title>\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<style>{STYLE}</style></head>\n<body>\n<main>\n<h1>{title}</h1>\n{body}\n</main>\n"
        "</body>\n</html>\n"
    )


def _rows(result: Delays, axis: str) -> tuple[Tried, ...]:
    return result.tried[axis]


def _amount(delay: int) -> str:
    if delay < 0:
        return "none"
    return f"{delay} ms, the most tried" if delay == DELAYS[-1] else f"{delay} ms"


def _most(result: Delays) -> float:
    margins = [one.margin for axis in AXES for one in result.tried[axis]]
    return max(margins) or 1.0


def _line(one: Tried, most: float, unit: str) -> str:
    if one.mishap is not None:
        return f"  {one.delay:3d} ms  {one.failed}"
    bar = "#" * max(1, round(BAR * one.margin / most))
    return f"  {one.delay:3d} ms  {bar:<{BAR}}  {one.margin:.2f} {unit}  {one.where}"


def _html_table(result: Delays, axis: str) -> str:
    what = "clear" if result.unit == "m" else "left"
    rows = "\n".join(
        f"<tr><td>{one.delay} ms</td><td>{one.margin:.2f} {result.unit}</td>"
        f"<td>{escape(one.failed or one.where)}</td></tr>"
        for one in _rows(result, axis)
    )
    head = f"<tr><th>delay</th><th>{what}</th><th>where it was least</th></tr>"
    return f"<table>\n{head}\n{rows}\n</table>"


def _plot(result: Delays, reference: Survived | None, axis: str) -> str:
    """Return bars: what is left at each delay; a full red one where the node fails."""
    rows, most = _rows(result, axis), _most(result)
    step = (WIDTH - LEFT) / len(rows)
    high = HEIGHT - BOTTOM - TOP
    parts = []
    for i, one in enumerate(rows):
        kind = "bad" if one.mishap else "bar"
        tall = high if one.mishap else high * one.margin / most
        x, y = LEFT + i * step + GAP / 2, HEIGHT - BOTTOM - tall
        tip = escape(one.failed or f"{one.margin:.2f} {result.unit}, {one.where}")
        parts.append(
            f'<rect class="{kind}" x="{x:.1f}" y="{y:.1f}" width="{step - GAP:.1f}" '
            f'height="{tall:.1f}"><title>{one.delay} ms: {tip}</title></rect>'
            f'<text x="{x + (step - GAP) / 2:.1f}" y="{HEIGHT - BOTTOM + 16}" '
            f'text-anchor="middle">{one.delay}</text>'
        )
    if reference is not None and reference.of(axis) >= 0:
        known = [i for i, one in enumerate(rows) if one.delay <= reference.of(axis)]
        x = LEFT + len(known) * step
        parts.append(
            f'<line class="reference" x1="{x:.1f}" x2="{x:.1f}" y1="{TOP}" y2="{HEIGHT - BOTTOM}"/>'
            f'<text x="{x - 4:.1f}" y="{TOP - 4}" text-anchor="end">the reference</text>'
        )
    label = escape(f"{NAMES[axis]}: {result.unit} left at each delay in ms")
    return (
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{label}">\n'
        f'<text x="0" y="{TOP + 8}">{most:.2f} {result.unit}</text>\n'
        f'<text x="{WIDTH}" y="{HEIGHT - 5}" text-anchor="end">delay [ms]</text>\n'
        + "\n".join(parts)
        + "\n</svg>"
    )
