"""What a node did in a drive, told in the terminal without judging it."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
from rich.markup import escape
from rich.padding import Padding

from grader.advice.slips import said_in
from grader.drive.topics import topic_lines
from grader.recording import Recording, account_of, ended_of, growth_of
from grader.recording.deaths import told_first
from grader.recording.words import told_lines
from grader.report.terminal import Console
from rclpy_virtual_time import Ended
from sim.messages import CMD_VEL_TOPIC
from sim.simulation import Truth

NO_MAIN = (
    'Does the file end with `if __name__ == "__main__": main()`? Python runs no function that '
    "nobody calls."
)
STAYS = "Should it have gone on? A node that waits for messages stays in rclpy.spin(node)."
STAND_IN = "the course's own {} ran in place of your programs; other scenarios run yours"
AT_ONCE = 0.01  # [s] in which a program ends that calls nothing
ADVICE = "try: "  # before what the account of an exception ends with
LAST_LINES = 12  # of a traceback
IN_REPLAY = "the replay shows them all"
LAST_WORDS = 10  # lines of what the node printed and logged


def print_summary(
    recording: Recording,
    *,
    file: str,
    seed: int | None = None,
    practice: str = "",
    most: int | None = LAST_WORDS,
    rest: str = IN_REPLAY,
) -> None:
    """Print which topics the node used, what happened, and what computing cost.

    `seed`: the one that was asked for. `practice`: why a grading of it would be for practice only.
    `most`: lines of what the node said; None: all. `rest`: where the others are.
    """
    console = Console(highlight=False)
    say = console.print
    world = "" if seed is None else f", seed {seed}"
    say(f"[bold]{escape(file)}[/] in [bold]{recording.name}[/]{world}")
    say()
    say("[bold]Topics[/]")
    for line in topic_lines(recording):
        text = line.lstrip()
        say(Padding(escape(text), (0, 0, 0, 2 + len(line) - len(text))))
    say()
    say("[bold]What happened[/]")
    for line in event_lines(recording):
        say(f"  {escape(line)}")
    detail = recording.outcome.detail
    told = _ending(recording)
    for line in told_first(detail) or detail.splitlines()[-LAST_LINES:]:
        if line.startswith(" ") or ": " not in line or line.partition(": ")[2] not in told:
            say(f"    {escape(line)}", style="dim")
    for line in account_of(recording):
        say(f"  {escape(line)}")
    for line in growth_of(recording):
        say(f"  WARNING: {escape(line)}")
    said = (line.text for line in recording.log if line.level == "stderr")
    for slip in filter(None, map(said_in, said)):
        say(f"  WARNING: line {slip.line}: {escape(slip.text)}")
    _print_words(recording, console, most, rest)
    if practice:
        say(f"  {practice}", style="yellow")


def _print_words(recording: Recording, console: Console, most: int | None, rest: str) -> None:
    """Print the node's last log lines, also those after Ctrl-C."""
    ending = recording.ending
    words = [*told_lines(recording.log), *(["(Ctrl-C)"] if ending and ending.log else [])]
    words += told_lines(ending.log) if ending else []
    if not words:
        return
    kept = words if most is None else words[-most:] if most else []
    left = len(words) - len(kept)
    console.print()
    more = f", the last {len(kept)} of {len(words)} lines ({rest})"
    console.print(f"[bold]What the node said[/]{more if left else ''}")
    for line in kept:
        console.print(f"  {escape(line)}", soft_wrap=most is None)
    if recording.log_truncated:
        console.print("  It said more than is kept.", style="yellow")


def touched_of(recording: Recording) -> list[str]:
    """Say in a sentence when the robot first touched something, if it did."""
    touched = recording.truth.t[recording.truth.contact]
    return [f"TOUCHED an obstacle at {t / 1e9:.1f} s" for t in touched[:1]]


def event_lines(recording: Recording) -> list[str]:
    """Return the drive's events, a line each."""
    truth = recording.truth
    live = recording.live
    lines = [
        f"{recording.duration_s:.1f} s {'of real time' if live else 'simulated'}; "
        f"{_ending(recording)}",
        *ended_of(recording),
    ]
    if given := recording.scenario.node.parameters:
        lines.append(f"started with {', '.join(f'{name}:={given[name]}' for name in given)}")
    lines += [STAND_IN.format(other)] if (other := recording.scenario.node.stand_in) else []
    lines += [f"WARNING: in real time, because {live.reason}"] if live and live.reason else []
    lines += [f"WARNING: the machine was too busy: {live.stall}"] if live and live.stall else []
    if len(truth.t):
        steps = np.hypot(np.diff(truth.x), np.diff(truth.y))
        nearest = int(np.argmin(truth.clearance))
        lines += [
            f"drove {steps.sum():.2f} m, from ({truth.x[0]:.2f}, {truth.y[0]:.2f}) "
            f"to ({truth.x[-1]:.2f}, {truth.y[-1]:.2f}); fastest {np.abs(truth.v).max():.2f} m/s"
            f"{_turned(truth)}",
            "the lidar sees what a bench says, whatever stands there"
            if recording.scenario.bench_scans
            else f"nearest to an obstacle: {truth.clearance[nearest]:.2f} m "
            f"at {truth.t[nearest] / 1e9:.1f} s",
        ]
        lines += touched_of(recording)
    if not any(m.topic == CMD_VEL_TOPIC for m in recording.published):
        lines.append("the robot got no command: nothing was published on /cmd_vel")
    if recording.outcome.kind == "returned":
        made_none = recording.outcome.text.endswith(Ended.NO_NODE)
        silent = not any(line.level == "stdout" for line in recording.log)
        at_once = recording.outcome.at < AT_ONCE
        lines.append(NO_MAIN if made_none and silent and at_once else STAYS)
    return lines + _last_lines(recording)


def _turned(truth: Truth) -> str:
    """Say how far the robot turned in all; "" if it didn't."""
    turned = math.degrees(np.abs(np.diff(np.unwrap(truth.yaw))).sum())
    return f"; turned {turned:.0f}°" if turned >= 1.0 else ""


def _last_lines(recording: Recording) -> list[str]:
    """Return lines on the effect of Ctrl-C, if there was any."""
    ending = recording.ending
    if ending is None:
        return []
    lines = [f"after Ctrl-C: {ending.problem}"] if ending.problem else []
    said = Counter(message.topic for message in ending.published)
    if said:
        sent = ", ".join(f"{count} on {topic}" for topic, count in said.items())
        lines.append(f"messages after Ctrl-C: {sent}")
    return lines


def _ending(recording: Recording) -> str:
    outcome = recording.outcome
    if outcome.completed:
        return "the node ran to the end"
    if outcome.by_itself:
        return f"the program ended by itself at {outcome.at:.1f} s"
    if outcome.kind == "held":
        return f"nothing was started: {outcome.text}"
    tried = [line for line in outcome.detail.splitlines() if line.startswith(ADVICE)]
    text = outcome.text.removesuffix(f"; {tried[-1].removeprefix(ADVICE)}" if tried else "")
    return f"the node ended at {outcome.at:.1f} s: {outcome.kind.replace('_', ' ')}: {text}"
