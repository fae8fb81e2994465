"""Draw the lesson's figures: `python lessons/figures.py` writes figures/*.svg, `--check` compares.

Their numbers are those of contract.toml, so a figure never says something else than the page.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

from contract import read
from strokes import (
    Figure,
    arrow,
    bar,
    bold,
    box,
    code,
    disc,
    dot,
    label,
    line,
    on_circle,
    ring,
    robot,
    sector,
    text,
)  # fmt: skip

from grader.course.generated import write_or_check

FOLDER = Path(__file__).with_name("figures")
NUMBERS = read()
LEFT, SCALE, END = 20.0, 0.7, 600  # of timelines: x of time 0, units per ms, last time [ms]


def says(key: str) -> str:
    """Return a number of the contract with its unit."""
    return NUMBERS[key].text


def value(key: str) -> float:
    """Return a number of the contract."""
    return NUMBERS[key].value


def at(milliseconds: float) -> float:
    """Return where a time lies on a timeline."""
    return LEFT + SCALE * milliseconds


def every(key: str, end: int = END + 1) -> range:
    """Return the times [ms] of something periodic."""
    return range(0, end, int(value(key)))


def loop() -> Figure:
    """Sensors, node, motors, world: the loop on topics."""
    stages = {"perception": "what is ahead?", "decision": "how fast?", "action": "say it"}
    parts = [box(10, 10, 440, 166, "grey", "paper"), label(24, 36, "your node")]
    for i, (stage, question) in enumerate(stages.items()):
        x = 22 + i * 142
        colour = "blue" if stage == "decision" else "ink"
        parts += [box(x, 54, 132, 64, colour), bold(x + 66, 82, stage, colour)]
        parts += [text(x + 66, 106, question, colour)]
    parts += [arrow((154, 86), (164, 86)), arrow((296, 86), (306, 86))]
    parts += [text(230, 142, "exchange this one,", "blue")]
    parts += [text(230, 162, "touch nothing else", "blue")]
    parts += [box(22, 236, 132, 44), text(88, 264, "lidar")]
    parts += [box(306, 236, 132, 44), text(372, 264, "motors")]
    parts += [arrow((88, 236), (88, 118)), arrow((372, 118), (372, 236))]
    parts += [code(98, 212, "/scan", at="start"), code(362, 212, "/cmd_vel", at="end")]
    parts += [box(164, 320, 132, 44, "green"), text(230, 348, "the world", "green")]
    parts += [arrow((372, 280), (372, 342), (296, 342), colour="green")]
    parts += [arrow((164, 342), (88, 342), (88, 280), colour="green")]
    parts += [label(380, 312, "moves", "green"), text(80, 312, "is seen", "green", "end")]
    return Figure(
        "The loop on topics",
        "The lidar publishes on /scan. In the node, perception, decision and action follow each "
        "other; action publishes on /cmd_vel, which moves the motors. The robot moves in the "
        "world, and the next scan shows it. Only the decision is exchanged when the model changes.",
        376,
        parts,
    )


def rates() -> Figure:
    """A lidar, a slow model and a control loop, each at its own rate."""
    period, model = value("lidar_period"), value("model_time")
    parts = [label(12, 18, f"scans, every {says('lidar_period')}", "blue")]
    for i, t in enumerate(every("lidar_period")):
        used = t % model == 0
        parts += [dot(at(t), 56, "blue") if used else ring(at(t), 56, "grey")]
        parts += [text(at(t), 40, str(i + 1), "blue" if used else "grey")]
    for t in every("model_time", END):
        parts += [bar(at(t), 112, model * SCALE - 3, 34, "orange")]
        parts += [arrow((at(t), 62), (at(t) + 3, 110), colour="blue")]
        parts += [text(at(t + model / 2), 135, "predict")]
    parts += [label(12, 172, f"the model, {says('model_time')}, with the newest scan", "orange")]
    for t in every("control_period"):
        begun = t // model * model - model  # when the newest prediction was begun [ms]
        behind, colour = ("0", "grey") if begun < 0 else (f"{begun / period + 1:g}", "green")
        parts += [line((at(t), 196), (at(t), 222), colour=colour), text(at(t), 242, behind, colour)]
    words = f"commands, every {says('control_period')}, and the scan behind each"
    parts += [label(12, 266, words, "green")]
    return Figure(
        "Sensor rate, model time and control rate",
        f"Scans come every {says('lidar_period')}. A prediction takes {says('model_time')} and "
        "starts with the newest scan, so every second scan is never used. Commands go out every "
        f"{says('control_period')}: zero at first, then the newest prediction, whose scan is "
        f"always at least {says('model_time')} old.",
        280,
        parts,
    )


def executors() -> Figure:
    """The same node under a single-threaded executor, and with callback groups and two threads."""
    model = value("model_time")
    parts = [bold(12, 22, "One thread: a callback waits for the other", at="start")]
    for t in every("model_time", END):
        parts += [bar(at(t) + 4, 44, model * SCALE - 8, 34, "orange")]
        parts += [bar(at(t), 190, model * SCALE - 3, 34, "orange")]
        parts += [text(at(t + model / 2), y, "predict") for y in (67, 213)]
    parts += [line((at(t), 36), (at(t), 86), colour="red") for t in every("model_time")]
    middle = at(1.5 * model)
    parts += [arrow((middle, 104), (at(end), 104), colour="red") for end in (model, 2 * model)]
    parts += [text(middle, 128, f"gap between commands: {says('alone_gap')}", "red")]
    parts += [bold(12, 174, "Two groups, two threads", at="start")]
    parts += [line((at(0), 254), (at(END), 254), colour="grey")]
    parts += [line((at(t), 242), (at(t), 266), colour="green") for t in every("control_period")]
    parts += [text(middle, 290, f"gap between commands: {says('together_gap')}", "green")]
    parts += [label(12, 322, "Bars: the model's callback. Strokes: the timer's, which")]
    parts += [label(12, 344, "publishes a command.")]
    return Figure(
        "One thread, and two callback groups with two threads",
        f"With one thread the timer of {says('control_period')} has to wait until the model is "
        f"done, so that commands are {says('alone_gap')} apart. With a callback group each and two "
        f"threads they are {says('together_gap')} apart, while the model works on beside them.",
        356,
        parts,
    )


def angle_min() -> Figure:
    """Where beam 0 points, and which beam points ahead, for three lidars."""
    half = value("wide_half")
    lidars = (  # middle, beams, angle of the first and of all [°], its name, where it looks
        (80, "lidar_beams", -180.0, 360.0, "from -π", "back"),
        (230, "lds_beams", 0.0, 360.0, "from 0", "ahead"),
        (380, "wide_beams", -half, 2 * half, "from -3π/4", "back right"),
    )
    parts: list[str] = []
    for x, beams, first, span, name, where in lidars:
        y, start = 130, on_circle(x, 130, 60, first)
        ahead = round(-first / (span / value(beams)))
        colour = "orange" if first else "green"
        parts += [bold(x, 22, name), text(x, 44, f"{says(beams)} beams", "grey")]
        whole = span == 360.0
        parts += [
            disc(x, y, 60, "blue") if whole else sector(x, y, 60, first, first + span, "blue")
        ]
        parts += [line((x, y), (x, y - 60), colour="green"), dot(x, y - 60, "green")]
        parts += [line((x, y), start, colour=colour), dot(*start, colour)]
        turn = [on_circle(x, y, 38, first + angle) for angle in range(20, 81, 10)]
        parts += [arrow(*turn, colour="grey"), robot(x, y)]
        parts += [code(x, 226, "ranges[0]", colour), text(x, 248, f"looks {where}", colour)]
        parts += [text(x, 280, "ahead is", "green"), code(x, 302, f"ranges[{ahead}]", "green")]
    parts += [bold(230, 336, "angle = angle_min + i · angle_increment")]
    parts += [text(230, 360, "positive to the left, so beams count counter-clockwise", "grey")]
    return Figure(
        "What angle_min means",
        "Three lidars from above, the robot looking up. With angle_min = -π the first beam looks "
        "back and the middle one looks ahead. With angle_min = 0 the first beam looks ahead. A "
        f"lidar of ±{says('wide_half')} begins behind its right side, and the middle beam looks "
        "ahead. Beams count counter-clockwise.",
        372,
        parts,
    )


def readings() -> Figure:
    """REP-117: what -inf, a number, +inf and NaN say."""
    rows = (
        ("-inf", "red", "too close to measure", "distance 0: stop"),
        ("0.87", "green", "a distance within the limits", "use it"),
        ("+inf", "blue", "nothing within range", "the way is free"),
        ("nan", "grey", "an erroneous reading", "ignore it"),
        ("0.0", "grey", "a number outside the limits", "ignore it"),
    )
    parts = [robot(30, 60), line((43, 60), (440, 60), colour="grey")]
    parts += [bar(44, 50, 46, 20, "red"), bar(92, 50, 228, 20, "green")]
    parts += [bar(322, 50, 110, 20, "blue")]
    parts += [line((91, 40), (91, 80)), line((321, 40), (321, 80))]
    parts += [code(91, 32, "range_min"), code(321, 32, "range_max")]
    parts += [code(67, 102, "-inf", "red"), text(206, 102, "a number [m]", "green")]
    parts += [code(376, 102, "+inf", "blue")]
    for i, (reading, colour, meaning, what_to_do) in enumerate(rows):
        y = 148 + 34 * i
        parts += [line((12, y - 23), (448, y - 23), colour="faint")]
        parts += [code(68, y, reading, colour, "end"), label(84, y, meaning, "ink")]
        parts += [text(448, y, what_to_do, colour, "end")]
    return Figure(
        "What a reading says (REP-117)",
        "Along a beam: closer than range_min the lidar says -inf, between range_min and range_max "
        "a number of metres, beyond it +inf. -inf counts as distance 0, +inf as a free way. NaN is "
        "an erroneous reading and is ignored, and so is a finite number outside the limits.",
        300,
        parts,
    )


def sectors() -> Figure:
    """The three sectors of the five features."""
    x, y, radius, half = 230, 168, 132, value("model_front")
    parts = [sector(x, y, radius, -half, half, "blue"), robot(x, y)]
    parts += [sector(x, y, radius, half, value("model_back"), "green")]
    parts += [sector(x, y, radius, -value("model_back"), -half, "orange"), robot(x, y)]
    parts += [bold(x, 72, "front", "blue"), text(x, 96, "minimum, mean,", "blue")]
    parts += [text(x, 116, "deviation", "blue")]
    parts += [bold(172, 212, "left", "green"), text(172, 234, "minimum", "green")]
    parts += [bold(288, 212, "right", "orange"), text(288, 234, "minimum", "orange")]
    for angle, sign, end in ((half, "+", "end"), (-half, "-", "start")):
        px, py = on_circle(x, y, radius + 10, angle)
        parts += [text(px, py, f"{sign}{says('model_front')}", "grey", end)]
    parts += [text(x, 26, "0°, ahead", "grey"), text(x, 322, f"±{says('model_back')}", "grey")]
    return Figure(
        "Five features from three sectors",
        f"The front sector reaches {says('model_front')} to either side and gives minimum, mean "
        "and standard deviation. The left sector, all the rest on the left, gives its minimum, "
        "and so does the right sector.",
        334,
        parts,
    )


def supervisor() -> Figure:
    """Between a model and the motors stands a node with rules."""
    parts = [box(12, 90, 118, 54), text(71, 113, "node with"), text(71, 133, "the model")]
    parts += [box(220, 60, 140, 114, "blue"), bold(290, 90, "supervisor", "blue")]
    rules = ("a few rules,", "that a person", "can check")
    parts += [text(290, 114 + 20 * i, words, "blue") for i, words in enumerate(rules)]
    parts += [arrow((130, 117), (220, 117)), code(175, 78, "/cmd_vel"), code(175, 98, "_raw")]
    parts += [arrow((360, 117), (404, 117), (404, 200)), code(410, 100, "/cmd_vel")]
    parts += [box(344, 200, 106, 44), text(397, 228, "motors")]
    parts += [arrow((250, 24), (250, 60)), arrow((330, 24), (330, 60))]
    parts += [code(244, 40, "/scan", at="end"), code(338, 40, "/e_stop", at="start")]
    parts += [arrow((290, 174), (290, 222), colour="green")]
    parts += [code(336, 242, "/diagnostics", "green", "end")]
    return Figure(
        "The supervisor between model and motors",
        "The node with the model publishes on /cmd_vel_raw. The supervisor hears that, /scan and "
        "/e_stop, publishes what is safe on /cmd_vel for the motors, and says why on /diagnostics.",
        258,
        parts,
    )


def service() -> Figure:
    """Three nodes ask one that owns the model."""
    parts = [box(150, 10, 160, 64, "blue"), bold(230, 36, "detection server", "blue")]
    parts += [text(230, 60, "one model", "blue"), code(96, 118, "/detect", at="end")]
    for i, role in enumerate(("navigation", "manipulation", "logging")):
        x, top = 12 + i * 150, 190 + i * 40
        parts += [box(x, 176, 136, 44), text(x + 68, 204, role)]
        parts += [arrow((x + 60, 176), (top - 6, 76))]
        parts += [arrow((top + 6, 74), (x + 76, 174), colour="green")]
    parts += [text(230, 250, "requests up, answers down; nobody waits in a callback", "grey")]
    return Figure(
        "One model behind a service",
        "Navigation, manipulation and logging each send requests to the service /detect of one "
        "detection server, which owns the only copy of the model, and get answers back.",
        262,
        parts,
    )


FIGURES: dict[str, Callable[[], Figure]] = {
    "loop": loop,
    "rates": rates,
    "executors": executors,
    "angle_min": angle_min,
    "readings": readings,
    "sectors": sectors,
    "supervisor": supervisor,
    "service": service,
}


def main(arguments: list[str]) -> int:
    """Write the files; with `--check`, tell which are not what this program draws."""
    drawn = ((FOLDER / f"{name}.svg", draw().svg(name)) for name, draw in FIGURES.items())
    return write_or_check(drawn, "python lessons/figures.py", arguments)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
