"""What the lesson's figures are drawn with: SVG in the page's colours, light or dark.

Each figure is 460 units wide with letters of 16, so that they have 12 pixels on a telephone, too.
The colours are those of the page that a figure stands in (conf.py) or, where a file stands alone,
its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from xml.sax.saxutils import escape

WIDTH = 460
LETTERS = 16
COLOURS = {  # variable of the page, and what stands in for it: light, dark
    "ink": ("--color-foreground-primary", "#1b1f24", "#e8eaed"),
    "paper": ("--color-background-primary", "#ffffff", "#131416"),
    "blue": ("--drawing-blue", "#0b5cad", "#7db8f5"),
    "green": ("--drawing-green", "#1f7a3d", "#7fd19a"),
    "orange": ("--drawing-orange", "#a34a00", "#f2a96b"),
    "red": ("--drawing-red", "#b3261e", "#f4958d"),
    "grey": ("--drawing-grey", "#5c6470", "#a8b0bb"),
    "shade": ("--drawing-shade", "#eef1f5", "#23282f"),
}


@dataclass(frozen=True)
class Figure:
    """A drawing, and what it says to those who do not see it."""

    title: str
    description: str
    height: int
    parts: Iterable[str]

    def svg(self, name: str) -> str:
        """Return the file; `name` keeps its ids apart from those of others on the page."""
        body = "\n".join(self.parts)
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {self.height}" '
            f'class="drawing" role="img" aria-labelledby="{name}-title {name}-description">\n'
            f'<title id="{name}-title">{escape(self.title)}</title>\n'
            f'<desc id="{name}-description">{escape(self.description)}</desc>\n'
            f"<style>{style()}</style>\n{body}\n</svg>\n"
        )


def style() -> str:
    """Return the rules for strokes, fills and letters; the same in every file."""
    rules = [f".drawing{{font:{LETTERS}px system-ui,sans-serif;{_colours(1)}}}"]
    rules += [f"@media (prefers-color-scheme:dark){{.drawing{{{_colours(2)}}}}}"]
    for name in COLOURS:
        rules += [f".drawing text.{name}{{fill:var(--d-{name})}}"]
        rules += [f".drawing .{name}-line{{stroke:var(--d-{name});stroke-width:2}}"]
        rules += [f".drawing .{name}-fill{{fill:var(--d-{name})}}"]
    rules += [".drawing .faint-line{stroke:var(--d-grey);stroke-width:1;opacity:.4}"]
    rules += [".drawing .no-fill{fill:none}.drawing .soft{fill-opacity:.18}"]
    rules += [".drawing .code{font-family:ui-monospace,monospace}.drawing .bold{font-weight:bold}"]
    return "".join(rules)


def _colours(column: int) -> str:
    return "".join(
        f"--d-{name}:var({values[0]},{values[column]});" for name, values in COLOURS.items()
    )


# --- words ---------------------------------------------------------------------------------


def text(x: float, y: float, words: str, colour: str = "ink", at: str = "middle") -> str:
    """Return a line of text; `at` is its anchor: start, middle or end."""
    place = f'x="{x:g}" y="{y:g}" class="{colour}" text-anchor="{at}"'
    return f"<text {place}>{escape(words)}</text>"


def label(x: float, y: float, words: str, colour: str = "grey") -> str:
    """Return a line of text that begins at x."""
    return text(x, y, words, colour, "start")


def bold(x: float, y: float, words: str, colour: str = "ink", at: str = "middle") -> str:
    """Return a heading."""
    return text(x, y, words, f"{colour} bold", at)


def code(x: float, y: float, words: str, colour: str = "ink", at: str = "middle") -> str:
    """Return a name as it stands in code."""
    return text(x, y, words, f"{colour} code", at)


# --- shapes --------------------------------------------------------------------------------


def box(
    x: float, y: float, width: float, height: float, colour: str = "ink", fill: str = "shade"
) -> str:
    """Return a box with round corners."""
    place = f'x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="8"'
    return f'<rect {place} class="{colour}-line {fill}-fill"/>'


def bar(x: float, y: float, width: float, height: float, colour: str) -> str:
    """Return a filled bar of a timeline."""
    place = f'x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="3"'
    return f'<rect {place} class="{colour}-line {colour}-fill soft"/>'


def line(*points: tuple[float, float], colour: str = "ink") -> str:
    """Return a polyline."""
    path = " ".join(f"{x:g},{y:g}" for x, y in points)
    return f'<polyline points="{path}" class="{colour}-line no-fill"/>'


def arrow(*points: tuple[float, float], colour: str = "ink") -> str:
    """Return a polyline with a head at its end."""
    (x0, y0), (x, y) = points[-2:]
    angle = math.atan2(y - y0, x - x0)
    wings = [
        (x - 9 * math.cos(angle + turn), y - 9 * math.sin(angle + turn)) for turn in (0.45, -0.45)
    ]
    head = " ".join(f"{round(a, 2):g},{round(b, 2):g}" for a, b in [(x, y), *wings])
    return line(*points, colour=colour) + f'<polygon points="{head}" class="{colour}-fill"/>'


def dot(x: float, y: float, colour: str) -> str:
    """Return a filled dot."""
    return f'<circle cx="{x:g}" cy="{y:g}" r="5" class="{colour}-fill"/>'


def ring(x: float, y: float, colour: str) -> str:
    """Return an empty dot."""
    return f'<circle cx="{x:g}" cy="{y:g}" r="4.5" class="{colour}-line paper-fill"/>'


def disc(x: float, y: float, radius: float, colour: str) -> str:
    """Return a tinted circle."""
    place = f'cx="{x:g}" cy="{y:g}" r="{radius:g}"'
    return f'<circle {place} class="{colour}-line {colour}-fill soft"/>'


def sector(x: float, y: float, radius: float, first: float, last: float, colour: str) -> str:
    """Return a slice between two angles [°], 0 upwards (ahead), positive to the left."""
    (x0, y0), (x1, y1) = (on_circle(x, y, radius, angle) for angle in (first, last))
    large = int(abs(last - first) > 180)
    arc = f"A{radius:g},{radius:g} 0 {large} 0 {x1:g},{y1:g}"
    path = f"M{x:g},{y:g} L{x0:g},{y0:g} {arc} Z"
    return f'<path d="{path}" class="{colour}-line {colour}-fill soft"/>'


def on_circle(x: float, y: float, radius: float, angle: float) -> tuple[float, float]:
    """Return a point in the direction of an angle [°], 0 upwards, positive to the left."""
    turn = math.radians(angle)
    return round(x - radius * math.sin(turn), 2), round(y - radius * math.cos(turn), 2)


def robot(x: float, y: float) -> str:
    """Return the robot from above, looking up."""
    nose = f"{x:g},{y - 9:g} {x - 6:g},{y + 4:g} {x + 6:g},{y + 4:g}"
    body = f'<circle cx="{x:g}" cy="{y:g}" r="13" class="ink-line paper-fill"/>'
    return body + f'<polygon points="{nose}" class="ink-fill"/>'
