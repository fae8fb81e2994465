"""Does the node run, with the right topics? A diagnosis for each way in which it may not.

The other checks need this one, so that a misspelt topic is reported as a misspelt topic, and not as
fifteen failures without a cause.
"""

from __future__ import annotations

import difflib
from typing import NamedTuple, NoReturn

from grader.checks.verdict import fail
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
OURS = "/course_"  # prefix of the nodes that the grader runs beside the student's
KINDS = {
    "publish": "publisher",
    "subscribe": "subscription",
    "serve": "service",
    "call": "client",
}


class _Wanted(NamedTuple):
    """An end of a topic or service that a node has to have."""

    kind: str  # publisher, subscription, service or client
    name: str  # of the topic or service
    type: str
    node: str  # which has to have it; "" if the exercise has only one node


def require_wiring(recording: Recording, slug: str, *nodes: str) -> None:
    """Fail unless the program ran to the end and has the topics and services of its exercise.

    Where an exercise has several nodes, `nodes` are those that take part in the scenario.
    """
    require_alive(recording)
    exercise = find_exercise(slug)
    ends: tuple[Topic | Service, ...] = (*exercise.topics, *exercise.services)
    for end in ends:
        if not nodes or end.node in nodes:
            _require_end(recording, _Wanted(KINDS[end.direction], end.name, end.type, end.node))


def require_alive(recording: Recording) -> None:
    """Fail if the node's program did not run to the scenario's end, and say why."""
    outcome = recording.outcome
    if outcome.completed:
        return
    death = death_of(outcome.detail)
    text = outcome.text or f"the node's program ended ({outcome.kind})"
    if outcome.kind == "exception":
        _fail_of_exception(recording, text, death)
    ends = _ENDS.get(outcome.kind, "")
    if death and death.loop:
        ends = f"Does the loop of {death.loop} ever end? {ends}"
    if death and death.advice:
        ends = advice_on(death)
    if outcome.kind == "returned" and not recording.endpoints:
        ends = NO_NODE
    fail(
        text,
        expected="a node that runs until the end of the scenario",
        actual=outcome.kind.replace("_", " "),
        at=_time_of_end(recording),
        recording=recording,
        help=ends,
        where=lines_of(death),
    )


def _fail_of_exception(recording: Recording, text: str, death: Death | None) -> NoReturn:
    """Fail with the place of an exception, the message that was handled, and the lines."""
    last = _last_delivery(recording, death.topic if death else "")
    if death is None:
        where = f"a callback, after {last}" if last else "the start-up, before any message came"
    elif death.in_callback:
        where = death.place + (f", {'at' if death.topic else 'after'} {last}" if last else "")
    else:
        where = death.place + ("" if last else ", before any message came")
    if death and death.advice:  # told as what to look at next
        text = text.removesuffix(f"; {death.advice}")
    runs = bool(last) if death is None else death.in_callback
    fail(
        f"the node died of an exception in {where}: {text}",
        expected="a node that never dies of a message" if runs else "a node that starts and spins",
        actual=death.said if death and death.said else text,
        at=_time_of_end(recording),
        recording=recording,
        help=advice_on(death) or "Read the traceback from its last line upwards.",
        where=lines_of(death),
        title=SURVIVES if runs else "",
    )


def lines_of(death: Death | None) -> str:
    """Return the student's lines, innermost first."""
    return "\n".join(str(frame) for frame in death.frames) if death else ""


def _sentence(text: str) -> str:
    end = "" if text.endswith((".", "?", "!")) else "."
    first = text.split(" ", maxsplit=1)[0]
    return f"{text[0].upper() if first.isalpha() else text[0]}{text[1:]}{end}"


def _time_of_end(recording: Recording) -> float:
    """Return when the node ended [s]: with its last message, though the robot rolls on."""
    times = [m.time for m in (*recording.delivered[-1:], *recording.published[-1:])]
    return max(times, default=0) / 1e9


def _last_delivery(recording: Recording, topic: str) -> str:
    """Return the last message that the node was sent, in words; empty if there was none.

    `topic`: the last one on this topic, if there is one.
    """
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


def advice_on(death: Death | None) -> str:
    """Return what to try, or where to look."""
    if death is not None and death.advice:
        return _sentence(death.advice)
    inner = death.frames[0] if death is not None and death.frames else None
    return f"Look at line {inner.line} of {inner.file}, in {inner.function}." if inner else ""


def _require_end(recording: Recording, wanted: _Wanted) -> None:
    """Fail unless the node has this end, with the right type and a QoS that matches."""
    every = [end for end in recording.endpoints if not end.node.startswith(OURS)]
    every = [end for end in every if end.node == f"/{wanted.node}"] or every
    ends = [end for end in every if end.kind == wanted.kind]
    here = [end for end in ends if end.topic == wanted.name]
    if not here:
        _fail_missing(recording, wanted, every)
    typed = [end for end in here if end.type == wanted.type]
    if not typed:
        _fail_type(recording, wanted, here[0])
    if not any(end.matched for end in typed):
        end = typed[0]
        expected, advice = _qos_advice(end)
        fail(
            f"the {wanted.kind} of {wanted.name} and the robot cannot talk: "
            "their QoS does not match",
            expected=expected,
            actual=f"{end.reliability}, {end.durability}, depth {end.depth}: {end.mismatch}",
            recording=recording,
            help=f"{advice} ROS 2 reports this only as a warning in the log.",
        )


def _qos_advice(end: Endpoint) -> tuple[str, str]:
    """Return which profile the robot can serve, and what to do about this one."""
    if "reliab" in end.mismatch:
        return (
            "a subscription that also takes best effort: this robot's driver offers no more",
            "`qos_profile_sensor_data` takes both kinds; a plain depth asks for reliable.",
        )
    if "durab" in end.mismatch:
        return (
            "a volatile subscription: the robot keeps no old messages",
            "`qos_profile_sensor_data` or a plain depth is volatile.",
        )
    return "a profile that the robot can serve", "Compare the two ends with `ros2 topic info -v`."


def _fail_missing(recording: Recording, wanted: _Wanted, every: list[Endpoint]) -> None:
    kind, name = wanted.kind, wanted.name
    ends = [end for end in every if end.kind == kind]
    names = list(dict.fromkeys(end.topic for end in ends))
    near = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
    near = near or [end.topic for end in ends if end.type == wanted.type][:1]
    others = [end for end in every if end.topic == name]
    of_node = f" of {wanted.node}" if wanted.node else ""
    if near:
        problem = f"there is no {kind}{of_node} on {name}, but one on {near[0]}"
        actual, advice = f"a {kind} on {near[0]}", f"Is {near[0]} misspelt? It is {name}."
    elif others:
        problem = f"there is a {others[0].kind} on {name} where a {kind} is needed"
        actual = f"a {others[0].kind} on {name}"
        advice = (
            "A service answers, a client asks."
            if kind in ("service", "client")
            else "A publisher sends, a subscription receives."
        )
    else:
        problem = f"there is no {kind}{of_node} on {name}"
        actual = f"{kind}s on {', '.join(names)}" if names else f"no {kind} at all"
        advice = f"Create it in the constructor: self.create_{kind}(…)."
    fail(
        problem,
        expected=f"a {kind} of {wanted.type} on {name}",
        actual=actual,
        recording=recording,
        help=advice,
    )


def _fail_type(recording: Recording, wanted: _Wanted, end: Endpoint) -> None:
    kind, name = wanted.kind, wanted.name
    right, got = wanted.type.split("/")[-1], end.type.split("/")[-1]
    fail(
        f"the {kind} on {name} has the type {got}; the robot's end of it is {right}",
        expected=wanted.type,
        actual=end.type,
        recording=recording,
        help="ROS 2 never connects two ends of different types, and does not report it.",
    )
