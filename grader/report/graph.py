"""The graph of a run, drawn: nodes, topics and services; a table says the same.

An end that is connected with nothing is red, dashed and numbered. The sentences are those of the
terminal (grader.recording.wiring). Names and types are a student's: `_said` escapes them, where
they are put down.
"""

from __future__ import annotations

import html
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from statistics import mean
from typing import TYPE_CHECKING, NamedTuple

from grader.recording.wiring import Wiring
from rclpy_virtual_time import readable
from sim.messages import CMD_VEL_TOPIC, TWIST
from sim.sensors import OFFERED, SENSOR_TOPICS

if TYPE_CHECKING:
    from grader.recording import Endpoint, Recording

ROBOT, NOBODY = "the robot", "nobody"
MOST = 60  # ends that are drawn, those with faults first
NODE, TOPIC, GAP, LINE = 86, 156, 22, 14  # [px] widths, and the height of a line of text
WIDTH = 2 * NODE + TOPIC + 2 * GAP  # fits a phone
OF_NODE, OF_TOPIC, SMALL = 10, 20, 22  # characters of a line in a box
MOST_LINES = 4  # of one name
FROM = {"publisher": "topic", "client": "service", "action client": "action"}  # kinds of ends
TO = {"subscription": "topic", "service": "service", "action server": "action"}


class _Link(NamedTuple):
    """An end of a topic, service or action."""

    topic: tuple[str, str]  # its name, and what it is
    side: int  # 0: from where messages come, 1: where they go
    node: str
    type: str
    quality: str = ""
    messages: str = ""
    number: int = 0  # of its fault


Topics = dict[tuple[str, str], list[_Link]]
Bad = set[tuple[str, str]]  # topics with a fault, or that the robot would hear instead


def graph_html(recording: Recording, *, judge: bool = True) -> str:
    """Return the graph as HTML that is safe to show; "" if no node had any end.

    `judge`: whether to say what is wrong.
    """
    wiring, own = Wiring(recording), set(recording.ends if judge else ())
    ends = [end for end in dict.fromkeys(recording.endpoints) if end.kind in FROM | TO]
    if not ends:
        return ""
    judged = [end for end in ends if end in own][: 3 * MOST]
    faults = {end: text for end in judged if (text := wiring.fault(end))}
    numbers = {end: i for i, end in enumerate(faults, 1)}
    shown = sorted(ends, key=lambda end: end not in faults)[:MOST]
    topics = _topics([*_own(wiring, shown, numbers), *_robots(recording, wiring, bool(faults))])
    meant = any(text.endswith(CMD_VEL_TOPIC) for text in faults.values())
    bad = {t for t, links in topics.items() if any(e.number for e in links)}
    bad |= {t for t, links in topics.items()
            if meant and t[0] == CMD_VEL_TOPIC and all(e.side for e in links)}  # fmt: skip
    nodes, counts = len({end.node for end in shown}), Counter(what for _, what in topics)
    counted = [_plural(counts[what], what) for what in TO.values() if counts[what]]
    about = ", ".join([_plural(nodes, "node"), *counted])
    left = len(ends) - len(shown)
    about += f"; {_plural(left, 'end')} left out" if left else ""
    silent = faults and not any(m.topic == CMD_VEL_TOPIC for m in recording.published)
    kind = " is-first" if faults or nodes > 1 else ""
    told = f' <b class="graph-sign">✗ {_plural(len(faults), "fault")}</b>' if faults else ""
    items = "".join(
        f"<li><b>{_said(end.topic)}</b>, {_said(end.node)}: {_said(text)}</li>"
        for end, text in [*faults.items()][:MOST]
    )
    return (
        f'<details class="graph-part{kind}"{" open" * bool(silent)}>'
        f"<summary>The graph <span>{about}</span>{told}</summary>"
        f'<div class="graph">{f"<ol>{items}</ol>" if items else ""}'
        f"{_svg(topics, bad, f'The graph: {about}. The table says the same.')}"
        f"{_table(topics, bad)}"
        "</div></details>"
    )


def _own(wiring: Wiring, ends: Iterable[Endpoint], numbers: dict[Endpoint, int]) -> Iterator[_Link]:
    for end in ends:
        quality = end.reliability.replace("_", " ")
        quality += ", transient local" if end.durability == "transient_local" else ""
        topic, side = (end.topic, (FROM | TO)[end.kind]), int(end.kind in TO)
        messages, number = wiring.messages(end), numbers.get(end, 0)
        yield _Link(topic, side, end.node, end.type, quality, messages, number)


def _robots(recording: Recording, wiring: Wiring, all_: bool) -> Iterator[_Link]:
    """Yield the robot's ends; those that nobody else is at only where something is wrong."""
    others = {end.topic for end in recording.endpoints}
    lossy = SENSOR_TOPICS if recording.scenario.qos.sensors != "reliable" else ()
    for topic, count in sorted(wiring.sent.items()):
        if topic in others or (all_ and topic in SENSOR_TOPICS):
            quality, type_ = "best effort" if topic in lossy else "reliable", OFFERED.get(topic, "")
            yield _Link((topic, "topic"), 0, ROBOT, type_, quality, wiring.told(count))
    if all_ or CMD_VEL_TOPIC in others:
        count = sum(n for (topic, _), n in wiring.said.items() if topic == CMD_VEL_TOPIC)
        yield _Link((CMD_VEL_TOPIC, "topic"), 1, ROBOT, TWIST, "", wiring.told(count))


def _topics(links: Sequence[_Link]) -> Topics:
    """Return ends by topics, in the order of the flow, from the robot's sensors to its motors."""
    ranks, rank, reached = dict[tuple[str, str], int](), 1, {ROBOT}
    by = {link.topic: link.node for link in links if not link.side}
    new = {link.topic for link in links if by.get(link.topic, ROBOT) == ROBOT}
    while new:
        ranks |= dict.fromkeys(new, rank)
        rank += 1
        reached |= {link.node for link in links if link.side and link.topic in new}
        new = {e.topic for e in links if not e.side and e.node in reached} - ranks.keys()
    ranks |= {link.topic: rank + 1 for link in links if link.side and link.node == ROBOT}
    every = {link.topic for link in links}
    topics = sorted(every, key=lambda t: (ranks.get(t, rank), by.get(t, ""), t))
    return {topic: [link for link in links if link.topic == topic] for topic in topics}


# --- the drawing ----------------------------------------------------------------------------------


def _svg(topics: Topics, bad: Bad, label: str) -> str:
    """Return the drawing: nodes that send, topics, nodes that hear, from left to right."""
    texts = {topic: _inside(topic, links) for topic, links in topics.items()}
    middles, height = _stack([*texts.values()], [0.0] * len(texts))
    middle = dict(zip(topics, middles, strict=True))
    drawn = ""
    for side, x in enumerate((0, WIDTH - NODE)):
        rows: dict[tuple[str, object], list[_Link]] = {}  # a box's links, by name and presence
        for topic, links in topics.items():
            for link in links:
                if link.side == side:
                    rows.setdefault((link.node, None), []).append(link)
            if topic in bad and all(link.side != side for link in links):
                rows[NOBODY, topic] = [_Link(topic, side, NOBODY, "", number=-1)]
        names = [[(line, "") for line in _wrapped(name, OF_NODE)] for name, _ in rows]
        wanted = [mean(middle[link.topic] for link in links) for links in rows.values()]
        middles, bottom = _stack(names, wanted)
        height = max(height, bottom)
        for y, lines, (name, absent) in zip(middles, names, rows, strict=True):
            kind = "nobody" if absent else "robot" if name == ROBOT else "node"
            drawn += "".join(_edge(y, middle[e.topic], e) for e in rows[name, absent])
            drawn += _box(f"graph-{kind}", x, y, NODE, lines)
    for topic, lines in texts.items():
        kind = f"graph-topic{' is-bad' * (topic in bad)}"
        drawn += _box(kind, NODE + GAP, middle[topic], TOPIC, lines)
    return (
        f'<svg class="graph-drawn" viewBox="-1 0 {WIDTH + 2} {height + 1:g}" role="img" '
        f'aria-label="{label}">{drawn}</svg>'
    )


def _inside(topic: tuple[str, str], links: Sequence[_Link]) -> list[tuple[str, str]]:
    """Return the lines in a topic's box, with their classes: name, types, QoS, messages."""
    name, what = topic
    sides = [{e.quality: 0 for e in links if e.side == side and e.quality} for side in (0, 1)]
    qualities = dict.fromkeys(" or ".join(side) for side in sides if side)
    counted = dict.fromkeys(link.messages for link in links if not link.side) or ["0 messages"]
    small = [
        re.sub("/(msg|srv|action)/", "/", type_) for type_ in dict.fromkeys(e.type for e in links)
    ]
    small += [what] if what != "topic" else [" → ".join(qualities), *counted]
    lines = [(line, "graph-name") for line in _wrapped(name, OF_TOPIC)]
    return [*lines, *((line, "") for text in filter(None, small) for line in _wrapped(text, SMALL))]


def _height(lines: Sequence[object]) -> int:
    return LINE * len(lines) + 12


def _stack(boxes: Sequence[Sequence[object]], wanted: Sequence[float]) -> tuple[list[float], float]:
    """Return the middles of boxes below one another, each where it is wanted or further down.

    Also return where the last of them ends.
    """
    found, bottom = [0.0] * len(boxes), 1.0 - LINE
    for i in sorted(range(len(boxes)), key=lambda i: wanted[i]):
        found[i] = max(wanted[i], bottom + LINE + _height(boxes[i]) / 2)
        bottom = found[i] + _height(boxes[i]) / 2
    return found, bottom


def _box(kind: str, x: int, y: float, width: int, lines: Sequence[tuple[str, str]]) -> str:
    height = _height(lines)
    texts = "".join(
        f'<text class="{of}" x="{x + width // 2}" y="{y - height / 2 + 17 + LINE * i:g}">'
        f"{_said(line)}</text>"
        for i, (line, of) in enumerate(lines)
    )
    return (
        f'<g class="{kind}"><rect x="{x}" y="{y - height / 2:g}" width="{width}" '
        f'height="{height}" rx="{4 if width == TOPIC else 14}"/>{texts}</g>'
    )


def _edge(node: float, topic: float, link: _Link) -> str:
    """Return an arrow from a node to a topic, or from there to a node; their heights are given."""
    x, begin, end = (NODE + GAP + TOPIC, topic, node) if link.side else (NODE, node, topic)
    half, to, y = x + GAP / 2, x + GAP, (begin + end) / 2
    way = f"M{x} {begin:g}C{half:g} {begin:g} {half:g} {end:g} {to - 4} {end:g}"
    drawn = f'<path d="{way}"/><path class="graph-head" d="M{to - 7} {end - 4:g}l7 4l-7 4z"/>'
    if link.number < 0:  # nobody's
        return f'<g class="graph-edge is-missing"><path d="{way}"/></g>'
    if not link.number:
        return f'<g class="graph-edge">{drawn}</g>'
    mark = f'<circle cx="{half:g}" cy="{y:g}" r="9"/><text x="{half:g}" y="{y + 4:g}">'
    return f'<g class="graph-edge is-bad">{drawn}{mark}{link.number}</text></g>'


def _wrapped(name: str, most: int) -> list[str]:
    """Return a name in lines that fit a box, broken behind its own signs where it can be."""
    lines = [""]
    for part in re.findall(rf"[^/_ .]{{1,{most - 1}}}[/_ .]?|[/_ .]", readable(name)[:200]):
        if len(lines[-1] + part.rstrip()) > most:
            lines.append("")
        lines[-1] += part
    return lines if len(lines) <= MOST_LINES else [*lines[: MOST_LINES - 1], "…"]


# --- in words -------------------------------------------------------------------------------------


def _table(topics: Topics, bad: Bad) -> str:
    rows = "".join(
        f'<tr><th scope="row">{_name(topic[0])}<span>'
        f"{_name(' and '.join(dict.fromkeys(link.type for link in links)))}</span></th>"
        f"{_cell(links, 0, topic in bad)}{_cell(links, 1, topic in bad)}</tr>"
        for topic, links in topics.items()
    )
    heads = "".join(f'<th scope="col">{head}</th>' for head in ("Topic, type", "From", "To"))
    return f"<table><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table>"


def _cell(links: Iterable[_Link], side: int, bad: bool) -> str:
    told = "".join(
        f"<p>{_name(link.node)}<span>{_said(', '.join(filter(None, link[4:6])))}</span>"
        + (f'<b class="graph-sign">✗ {link.number}</b></p>' if link.number else "</p>")
        for link in links
        if link.side == side
    )
    nobody = f'<b class="graph-sign">✗ {NOBODY}</b>' if bad else NOBODY
    return f"<td>{told or nobody}</td>"


def _plural(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


def _name(text: str) -> str:
    return _said(text).replace("/", "/<wbr>")


def _said(text: str) -> str:
    """Return a text as HTML, without what is not seen or turns its line around."""
    return html.escape(readable(text).encode("utf-8", "replace").decode("utf-8"))
