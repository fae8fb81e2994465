"""Does the node run, with the right topics? A diagnosis for each way in which it may not.

The other checks need this one, so that a misspelt topic is reported as a misspelt topic, and not as
fifteen failures without a cause.
"""

from __future__ import annotations

import difflib
import re
from typing import NoReturn

from grader.checks.verdict import fail, inconclusive
from grader.course.exercises import Service, Topic, find_exercise
from grader.recording import Death, Endpoint, Recording, death_of

_ENDS = {
    "missing": "Put all files of the exercise into one folder, and grade that folder.",
    "unreadable": "Open the file in an editor and look at the line.",
    "syntax_error": "Python cannot read the file. Run `python3 FILE` yourself: it shows the line.",
    "returned": "main() has to stay in rclpy.spin(node) (or an executor's spin) until Ctrl-C.",
    "exited": "Something called exit(); a node runs until Ctrl-C.",
    "died": "The whole process ended. Did native code crash, or did it run out of memory?",
    "hung": "A callback must return; a loop inside one that waits for the next message never ends.",
    "never_spun": "Call rclpy.spin(node): without it ROS calls no callback, however long it waits.",
    "flooded": "Does something publish in a loop without waiting?",
}

NO_NODE = (
    'It never made a node: does the file end with `if __name__ == "__main__": main()`, and does '
    "main() make the node and spin it?"
)
SURVIVES = "The node survives every message that it gets."
REMAPPED = (
    "Its remapping is missing, or names something else: in each pair the program's own name stands "
    "first, as it stands there, without a slash; then the name to reach."
)
KINDS = {
    "publish": "publisher",
    "subscribe": "subscription",
    "serve": "service",
    "call": "client",
}
WHO = "A publisher sends, a subscription receives; a service answers, a client asks."
QOS = {  # by what ROS calls the mismatch: which profile the robot can serve, and what to do
    "reliab": (
        "a subscription that also takes best effort: this robot's driver offers no more",
        "`qos_profile_sensor_data` takes both kinds; a plain depth asks for reliable.",
    ),
    "durab": (
        "a volatile subscription: the robot keeps no old messages",
        "`qos_profile_sensor_data` or a plain depth is volatile.",
    ),
    "": ("a profile that the robot can serve", "Compare the ends with `ros2 topic info -v`."),
}
Wanted = Topic | Service  # an end that a node has to have


def require_wiring(recording: Recording, slug: str, *nodes: str) -> None:
    """Fail unless the program ran to the end and has the topics and services of its exercise.

    Where an exercise has several nodes, `nodes` are those that take part in the scenario.
    """
    require_alive(recording)
    exercise = find_exercise(slug)
    ends: tuple[Wanted, ...] = (*exercise.topics, *exercise.services)
    for end in ends:
        if not nodes or end.node in nodes:
            require_end(recording, end)


def require_alive(recording: Recording) -> None:
    """Fail if the node's program did not run to the scenario's end, and say why."""
    outcome = recording.outcome
    if outcome.completed:
        return
    if outcome.kind == "held":
        inconclusive(outcome.text)
    death = death_of(outcome.detail)
    text = outcome.text or f"the node's program ended ({outcome.kind})"
    if outcome.kind == "exception":
        _fail_of_exception(recording, text, death)
    own = [program.file for program in recording.scenario.program if not program.supplied]
    if len(own) == 1 and own[0] not in text:  # one of several files
        text = f"{own[0]}: {text}".removeprefix(": ")
    advice = _ENDS.get(outcome.kind, "")
    if outcome.kind == "unreadable" and "line " not in text:  # an empty file, a package
        advice = ""
    if death and death.loop:
        advice = f"Does the loop of {death.loop} ever end? {advice}"
    if death and death.advice:
        advice = advice_on(death)
    if outcome.kind == "returned" and not recording.ends:
        advice = NO_NODE
    fail(
        text,
        expected="a node that runs until the end of the scenario",
        actual=outcome.kind.replace("_", " "),
        at=_time_of_end(recording),
        recording=recording,
        help=advice,
        where=lines_of(death) or _place_in(text),
    )


def _place_in(text: str) -> str:
    """Return the line that a text begins with, as a frame has it; "" if none."""
    place = re.match(r"(?P<file>[^\s,]{1,100}), line (?P<line>\d{1,6}): ", text)
    return f"line {place['line']} of {place['file']}" if place else ""


def lines_of(death: Death | None) -> str:
    """Return the student's lines, innermost first."""
    return "\n".join(str(frame) for frame in death.frames) if death else ""


def advice_on(death: Death | None) -> str:
    """Return what to try, or where to look."""
    if death is not None and death.advice:
        end = "" if death.advice.endswith((".", "?", "!")) else "."
        is_word = death.advice.split(" ", maxsplit=1)[0].isalpha()
        return f"{death.advice[0].upper() if is_word else death.advice[0]}{death.advice[1:]}{end}"
    inner = death.frames[0] if death is not None and death.frames else None
    return f"Look at line {inner.line} of {inner.file}, in {inner.function}." if inner else ""


def _fail_of_exception(recording: Recording, text: str, death: Death | None) -> NoReturn:
    """Fail with the place of an exception, the message that was handled, and the lines."""
    last = _last_delivery(recording, death.topic if death else "")
    runs = bool(last) if death is None else death.in_callback
    place = death.place if death else "a callback" if runs else "the start-up"
    if last and runs:
        place += f", after {last}"
    if death and death.advice:  # it is the help
        text = text.removesuffix(f"; {death.advice}")
    fail(
        f"the node died of an exception in {place}: {text}",
        expected="a node that never dies of a message" if runs else "a node that starts and spins",
        actual=death.said if death and death.said else text,
        at=_time_of_end(recording),
        recording=recording,
        help=advice_on(death) or "Read the traceback from its last line upwards.",
        where=lines_of(death),
        title=SURVIVES if runs else "",
    )


def _time_of_end(recording: Recording) -> float:
    """Return when the node ended [s]: with its last message, though the robot rolls on."""
    times = [m.time for m in (*recording.delivered[-1:], *recording.published[-1:])]
    return max(times, default=0) / 1e9


def _last_delivery(recording: Recording, topic: str) -> str:
    """Describe the last message sent to the node, on this topic if the topic had any."""
    if not recording.delivered:
        return ""
    on_topic = [message for message in recording.delivered if message.topic == topic]
    message = (on_topic or recording.delivered)[-1]
    text = f"the message on {message.topic} at {message.time / 1e9:.3f} s"
    bench = recording.scenario.bench_scans
    index = len(recording.scans()) - 1
    if message.topic == "/scan" and index < len(bench) and bench[index].label:
        text += f" (“{bench[index].label}”)"
    return text


def require_end(recording: Recording, wanted: Wanted) -> None:
    """Fail unless the node has this end, with the right type and a QoS that matches."""
    kind = KINDS[wanted.direction]
    every = [end for end in recording.ends if end.node == f"/{wanted.node}"] or [*recording.ends]
    here = [end for end in every if (end.kind, end.topic) == (kind, wanted.name)]
    typed = [end for end in here if end.type == wanted.type]
    if not here:
        _fail_missing(recording, wanted, every)
    if not typed:
        fail(
            f"the {kind} on {wanted.name} has the type {here[0].type.split('/')[-1]}; "
            f"the robot's end of it is {wanted.type.split('/')[-1]}",
            expected=wanted.type,
            actual=here[0].type,
            recording=recording,
            help="ROS 2 never connects two ends of different types, and does not report it.",
        )
    if not any(end.matched for end in typed):
        end = typed[0]
        expected, advice = next(said for word, said in QOS.items() if word in end.mismatch)
        fail(
            f"the {kind} of {wanted.name} and the robot cannot talk: their QoS does not match",
            expected=expected,
            actual=f"{end.reliability}, {end.durability}, depth {end.depth}: {end.mismatch}",
            recording=recording,
            help=f"{advice} ROS 2 reports this only as a warning in the log.",
        )


def _fail_missing(recording: Recording, wanted: Wanted, every: list[Endpoint]) -> NoReturn:
    """Fail for a missing endpoint; name the endpoint that may have been meant."""
    kind, name = KINDS[wanted.direction], wanted.name
    ends = [end for end in every if end.kind == kind]
    near = difflib.get_close_matches(name, [end.topic for end in ends], n=1, cutoff=0.5)
    near = near or [end.topic for end in ends if end.type == wanted.type]
    others = [end.kind for end in every if end.topic == name]
    problem = f"there is no {kind}{f' of {wanted.node}' if wanted.node else ''} on {name}"
    actual = f"{kind}s on {', '.join(end.topic for end in ends)}" if ends else f"no {kind} at all"
    advice = f"Create it in the constructor: self.create_{kind}(…)."
    if near:
        problem += f", but one on {near[0]}"
        how = "in a namespace, remapped, or " if near[0].endswith(name) else ""
        advice = f"Is {near[0]} {how}misspelt? It is {name}."
        if near[0] == f"/{name.rpartition('/')[2]}":
            advice = f"A name that begins with a slash leaves the namespace: write {near[0][1:]}."
        if recording.scenario.node.stand_in:  # the programs are ours
            advice = REMAPPED
    elif others:
        problem, advice = f"there is a {others[0]} on {name} where a {kind} is needed", WHO
    fail(
        problem,
        expected=f"a {kind} of {wanted.type} on {name}",
        actual=actual,
        recording=recording,
        help=advice,
    )
