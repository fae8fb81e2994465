"""What a node did in a drive, told in the terminal without judging it."""

from __future__ import annotations

from collections import Counter

import numpy as np
from rich.console import Console
from rich.markup import escape

from grader.recording import Endpoint, Recording, account_of, growth_of
from grader.recording.deaths import told_first
from grader.recording.words import last_words
from grader.report.terminal import printable
from sim.messages import CMD_VEL_TOPIC, TWIST_STAMPED

LAST_LINES = 12  # of a traceback
LAST_WORDS = 10  # lines of what the node printed and logged


def print_summary(recording: Recording, *, file: str, practice: str = "") -> None:
    """Print which topics the node used, what happened, and what computing cost.

    `practice`: why a grading of it would be for practice only.
    """
    console = Console(highlight=False)
    say = console.print
    say(f"[bold]{escape(file)}[/] in [bold]{recording.name}[/], seed {recording.seed}")
    say()
    say("[bold]Topics[/]")
    for line in _topic_lines(recording):
        say(f"  {escape(printable(line, console))}")
    say()
    say("[bold]What happened[/]")
    for line in event_lines(recording):
        say(f"  {escape(printable(line, console))}")
    detail = recording.outcome.detail
    for line in told_first(detail) or detail.splitlines()[-LAST_LINES:]:
        say(f"    {escape(printable(line, console))}", style="dim")
    for line in account_of(recording):
        say(f"  {line}")
    for line in growth_of(recording):
        say(f"  {escape(printable('WARNING: ' + line, console))}")
    if said := last_words(recording, LAST_WORDS):
        say()
        say("[bold]What the node said[/]" + (", the last lines" if len(recording.log) > LAST_WORDS
                                             else ""))  # fmt: skip
        for line in said:
            say(f"  {escape(printable(line, console))}")
    if practice:
        say(f"  {practice}", style="yellow")


def _topic_lines(recording: Recording) -> list[str]:
    if not recording.endpoints:
        return ["the node created no publisher and no subscription"]
    sent = Counter(message.topic for message in recording.delivered)
    said = Counter(message.topic for message in recording.published)
    return [
        _topic_line(end, said if end.kind == "publisher" else sent, recording.duration_s)
        for end in recording.endpoints
        if end.kind != "timer"
    ]


def _topic_line(end: Endpoint, counts: Counter[str], duration: float) -> str:
    arrow = {"publisher": "->", "subscription": "<-"}.get(end.kind, end.kind)
    line = f"{arrow} {end.topic}  {end.type}"
    if end.kind not in ("publisher", "subscription"):
        return line
    rate = counts[end.topic] / duration if duration else 0.0
    line += f"  {end.reliability}  {counts[end.topic]} messages ({rate:.1f} Hz)"
    if end.mismatch:
        line += f"  WARNING: nothing arrives: {end.mismatch}"
    elif end.kind == "publisher" and end.topic == CMD_VEL_TOPIC and end.type == TWIST_STAMPED:
        line += "  note: the exercises expect Twist here; the robot understood"
    elif end.kind == "subscription" and not counts[end.topic]:
        line += "  WARNING: the robot sends nothing on this topic"
    return line


def event_lines(recording: Recording) -> list[str]:
    """Return what happened, a line each."""
    truth = recording.truth
    lines = [f"{recording.duration_s:.1f} s simulated; {_ending(recording)}"]
    if len(truth.t):
        steps = np.hypot(np.diff(truth.x), np.diff(truth.y))
        nearest = int(np.argmin(truth.clearance))
        lines += [
            f"drove {steps.sum():.2f} m, from ({truth.x[0]:.2f}, {truth.y[0]:.2f}) "
            f"to ({truth.x[-1]:.2f}, {truth.y[-1]:.2f}); fastest {np.abs(truth.v).max():.2f} m/s",
            f"nearest to an obstacle: {truth.clearance[nearest]:.2f} m "
            f"at {truth.t[nearest] / 1e9:.1f} s",
        ]
        touched = np.flatnonzero(truth.contact)
        if len(touched):
            lines.append(f"TOUCHED an obstacle at {truth.t[touched[0]] / 1e9:.1f} s")
    if not any(m.topic == CMD_VEL_TOPIC for m in recording.published):
        lines.append("the robot got no command: nothing was published on /cmd_vel")
    return lines


def _ending(recording: Recording) -> str:
    outcome = recording.outcome
    if outcome.completed:
        return "the node ran to the end"
    return f"the node ended at {outcome.at:.1f} s: {outcome.kind.replace('_', ' ')}: {outcome.text}"
