"""One trial: one node, one scenario, in lock-step, in virtual time.

The robot's next message and the node's commands meet here: the host runs up to the time of the next
message, the simulation follows with the commands that came out, and hands over what it measured.
"""

from __future__ import annotations

import shutil
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from grader.host.frames import (
    Delivery,
    Ended,
    EndpointReport,
    Offer,
    ProgramStart,
    Published,
    Run,
    Settled,
    Start,
)
from grader.launch import HostProcess, Nursery
from grader.link import Cost, HostDied, HostForged, HostHung, Link
from grader.log import LogLine
from grader.models import write_models
from grader.recording import COMPLETED, Compute, Endpoint, Outcome, Recording
from grader.submission import Submission
from sim.messages import (
    BOOL,
    CMD_VEL_RAW_TOPIC,
    CMD_VEL_TOPIC,
    E_STOP_TOPIC,
    EPOCH_NS,
    GOAL_TOPIC,
    LASER_SCAN,
    ODOM_TOPIC,
    ODOMETRY,
    POSE_STAMPED,
    SCAN_TOPIC,
    TWIST,
    TWIST_STAMPED,
    Message,
    twist_from_cdr,
    twist_stamped_from_cdr,
)
from sim.scenario import Scenario
from sim.simulation import Simulation

SUPPLIED = Path(__file__).parent / "host" / "supplied"  # programs of ours that run beside students'
MAX_BYTES = 64 * 1024 * 1024  # a node may publish in one trial
MESSAGE_BYTES = 128  # what a message takes besides its data and names
MAX_ENDPOINTS = 1_000
GRACE = 1.0  # [s] for the end of a process that has hung up
AFTERMATH_NS = 10**9  # the robot rolls on for this long when its node is gone
STUCK = (
    "the node stopped for good: every thread waits for something that can't come any more "
    "(a blocking call() or wait in a callback waits for an answer that only the executor "
    "it blocks could deliver)"
)
OURS = ("/course/", "/ground_truth/", "/rosout")  # topics of our own in a bag
OFFERED = {
    SCAN_TOPIC: LASER_SCAN,
    ODOM_TOPIC: ODOMETRY,
    GOAL_TOPIC: POSE_STAMPED,
    CMD_VEL_RAW_TOPIC: TWIST,
    E_STOP_TOPIC: BOOL,
}
SENSORS = {SCAN_TOPIC, ODOM_TOPIC}  # the topics that a scenario's QoS is about


@dataclass(frozen=True)
class Limits:
    """Wall-clock limits of a trial [s]; a correct node stays far below them on a slow machine."""

    start: float = 30.0  # importing libraries, constructing nodes, loading models
    step: float = 5.0  # between one message and the node's being done with it
    total: float = 120.0


@dataclass
class _Trial:
    """The growing record of a trial."""

    simulation: Simulation
    link: Link
    stamped: bool
    delivered: list[Message] = field(default_factory=list)
    published: list[Message] = field(default_factory=list)
    endpoints: list[Endpoint] = field(default_factory=list)
    compute: list[tuple[float, float, float]] = field(default_factory=list)
    bytes: int = 0
    at: float = 0.0  # [s] the time that the node has come to
    spun: bool = False
    stuck: float | None = None  # [s] since when nothing in the node can ever run again


def run_trial(
    submission: Submission,
    scenario: Scenario,
    nursery: Nursery,
    *,
    seed: int | None = None,
    arguments: Sequence[str] = (),
    limits: Limits | None = None,
    stamped: bool = False,
    files: Mapping[str, bytes] | None = None,
) -> Recording:
    """Run a student's file in a scenario and return what happened.

    Parameters
    ----------
    seed
        Takes the place of the scenario's own.
    arguments
        Command line of the file, such as ["--ros-args", "-p", "max_speed:=0.3"].
    stamped
        The robot takes TwistStamped as well as Twist.
    files
        Further files that the node finds in its working folder: name and content.

    Raises
    ------
    GraderError
        The grader or the machine failed; nothing can be said of the submission.
    """
    simulation = Simulation(scenario)
    if seed is not None:
        simulation.reset(seed=seed)
    if submission.problem:
        return not_run(simulation, Outcome("unreadable", submission.problem))
    if missing := _missing_file(scenario, submission):
        return not_run(simulation, Outcome("missing", missing))
    with submission.folder() as folder:
        write_models(scenario.node.models, folder)
        for name, content in (files or {}).items():
            (folder / name).write_bytes(content)
        return _run(submission, simulation, nursery, folder, arguments, limits, stamped)


def _programs(
    scenario: Scenario, submission: Submission, folder: Path, arguments: Sequence[str]
) -> tuple[ProgramStart, ...]:
    """Return what to run: the submission's own file, or what the scenario asks for."""
    common = (*arguments, *parameter_arguments(scenario.node.parameters))
    if not scenario.program:
        return (ProgramStart(str(folder / submission.path.name), common),)
    for spec in scenario.program:
        if spec.supplied:
            shutil.copyfile(SUPPLIED / spec.file, folder / spec.file)
    return tuple(
        ProgramStart(
            file=str(folder / spec.file),
            arguments=(*common, *spec.arguments),
            start=round(spec.start * 1e9),
            stop=None if spec.stop is None else round(spec.stop * 1e9),
        )
        for spec in scenario.program
    )


def _missing_file(scenario: Scenario, submission: Submission) -> str:
    """Say which of the scenario's programs the submission lacks; empty if none."""
    there = [path.name for path in (submission.path, *submission.others)]
    for spec in scenario.program:
        if not spec.supplied and spec.file not in there:
            return f"there is no {spec.file} in the submission, only {', '.join(there)}"
    return ""


def parameter_arguments(parameters: Mapping[str, str | bool | int | float]) -> list[str]:
    """Return the command line that sets ROS parameters."""
    if not parameters:
        return []
    texts = {
        name: str(value).lower() if isinstance(value, bool) else str(value)
        for name, value in parameters.items()
    }
    flags = [word for name, text in texts.items() for word in ("-p", f"{name}:={text}")]
    return ["--ros-args", *flags]


def _run(
    submission: Submission,
    simulation: Simulation,
    nursery: Nursery,
    folder: Path,
    arguments: Sequence[str],
    limits: Limits | None,
    stamped: bool,
) -> Recording:
    scenario = simulation.scenario
    with nursery.host(folder) as host:
        start = Start(
            programs=_programs(scenario, submission, folder, arguments),
            epoch=EPOCH_NS,
            seed=simulation.seed,
            offers=_offers(scenario),
        )
        trial = _Trial(simulation, Link(host), stamped)
        outcome = _conduct(trial, start, host, limits or Limits())
        return _freeze(trial, outcome, folder)


def _conduct(trial: _Trial, start: Start, host: HostProcess, limits: Limits) -> Outcome:
    """Run the trial to its end; say how it ended."""
    simulation = trial.simulation
    end = round(simulation.scenario.duration * 1e9)
    clock_end = time.perf_counter() + limits.total
    try:
        answer, cost = trial.link.start(start, limits.start)
        pending = _take(trial, answer, cost, began=0, agreed=0)
        while isinstance(answer, Settled) and simulation.now < end:
            if time.perf_counter() > clock_end:
                raise HostHung("")
            began = simulation.now
            trial.at = began / 1e9
            until = min(simulation.next_event() or end, end)
            frame = Run(until, tuple(Delivery(m.topic, m.data) for m in pending))
            trial.delivered += pending
            answer, cost = trial.link.run(frame, limits.step)
            pending = _take(trial, answer, cost, began, until)
    except HostHung as hung:
        text = "the node did not come back from a callback (or from its start-up)"
        return _outcome(trial, "hung", text, hung.stacks)
    except HostDied:
        status = host.wait(GRACE)
        text = f"the node's process ended by itself ({status_text(status)})"
        return _outcome(trial, "died", text)
    except (HostForged, _Flood) as error:
        kind = "flooded" if isinstance(error, _Flood) else "forged"
        return _outcome(trial, kind, f"the node sent more or other than a node can say: {error}")
    if isinstance(answer, Ended):
        return _outcome(trial, answer.kind, answer.text, answer.detail)
    if not trial.spun:
        return _outcome(trial, "never_spun", "the program runs, but its node never spins")
    if trial.stuck is not None:
        return Outcome("stuck", STUCK, trial.stuck)
    return _outcome(trial, COMPLETED, "")


class _Flood(Exception):
    """The node published too much."""


def _take(
    trial: _Trial, answer: Settled | Ended, cost: Cost, began: int, agreed: int
) -> list[Message]:
    """Note an answer, let the robot follow it; return the robot's next messages."""
    simulation = trial.simulation
    reached = _reached(answer, began, agreed)
    trial.at = reached / 1e9
    for report in answer.endpoints:
        trial.endpoints.append(_endpoint(report))
    if len(trial.endpoints) > MAX_ENDPOINTS:
        raise _Flood(f"more than {MAX_ENDPOINTS} endpoints")
    commands = []
    for published in answer.published:
        message = _message(trial, published, began, reached)
        trial.published.append(message)
        command = _command(message, trial.stamped)
        if command is not None:
            commands.append(command)
    trial.compute.append((began / 1e9, cost.wall, cost.cpu))
    if isinstance(answer, Settled):
        trial.spun = trial.spun or answer.spinning
        if answer.spinning or answer.asleep:
            trial.stuck = None
        elif trial.stuck is None:
            trial.stuck = reached / 1e9
        return simulation.advance(reached, commands)
    simulation.advance(min(reached + AFTERMATH_NS, _end(simulation)), commands)
    return []


def _reached(answer: Settled | Ended, began: int, agreed: int) -> int:
    """Return the time that the host has come to; it can't be any other than agreed on."""
    if isinstance(answer, Settled) and answer.now != agreed:
        raise HostForged(f"time {answer.now} where {agreed} was agreed on")
    if not began <= answer.now <= agreed:
        raise HostForged(f"an end at {answer.now}, between {began} and {agreed}")
    return answer.now


def _message(trial: _Trial, published: Published, began: int, reached: int) -> Message:
    if not began <= published.time <= reached:
        raise HostForged(f"a message at {published.time}, between {began} and {reached}")
    if trial.published and published.time < trial.published[-1].time:
        raise HostForged("messages that go back in time")
    names = len(published.topic) + len(published.type)
    trial.bytes += len(published.data) + names + MESSAGE_BYTES
    if trial.bytes > MAX_BYTES:
        raise _Flood(f"more than {MAX_BYTES:,} bytes of messages")
    topic = published.topic
    if topic in OFFERED or topic.startswith(OURS):  # a node that speaks in the robot's name
        topic = f"/from_node{topic}"
    return Message(topic, published.type, published.time, published.data)


def _command(message: Message, stamped: bool) -> tuple[int, float, float] | None:
    """Return what the robot's motors make of a message, if it is for them."""
    if message.topic != CMD_VEL_TOPIC:
        return None
    try:
        if message.type == TWIST:
            linear_x, _, _, _, _, angular_z = twist_from_cdr(message.data)
        elif stamped and message.type == TWIST_STAMPED:
            linear_x, _, _, _, _, angular_z = twist_stamped_from_cdr(message.data)
        else:
            return None
    except ValueError:
        return None
    return message.time, linear_x, angular_z


def _outcome(trial: _Trial, kind: str, text: str, detail: str = "") -> Outcome:
    return Outcome(kind, text, trial.at, detail)


def status_text(status: str) -> str:
    if status.startswith("-"):
        return f"signal {status[1:]}"
    return f"exit code {status or 'unknown'}"


def _end(simulation: Simulation) -> int:
    return round(simulation.scenario.duration * 1e9)


def _offers(scenario: Scenario) -> tuple[Offer, ...]:
    reliable = scenario.qos.sensors == "reliable"
    return tuple(
        Offer(topic, type, reliable or topic not in SENSORS) for topic, type in OFFERED.items()
    )


def _endpoint(report: EndpointReport) -> Endpoint:
    return Endpoint(
        report.kind,
        report.node,
        report.topic,
        report.type,
        report.reliability,
        report.durability,
        report.depth,
        report.mismatch,
    )


def _freeze(trial: _Trial, outcome: Outcome, folder: Path) -> Recording:
    compute = np.array(trial.compute, dtype=float).reshape(-1, 3).T
    log = trial.link.log()
    output = (trial.link.stdout, trial.link.stderr)
    return Recording(
        scenario=trial.simulation.scenario,
        layout=trial.simulation.layout,
        seed=trial.simulation.seed,
        duration_s=trial.simulation.now / 1e9,
        delivered=tuple(trial.delivered),
        published=tuple(trial.published),
        truth=trial.simulation.truth(),
        outcome=without_folder(outcome, folder),
        endpoints=tuple(trial.endpoints),
        log=tuple(line_without_folder(line, folder) for line in log),
        log_truncated=any(stream.truncated for stream in output),
        compute=Compute(*compute),
    )


def without_folder(outcome: Outcome, folder: Path) -> Outcome:
    """Show paths as the student knows them: the copy's folder changes from run to run."""
    prefix = f"{folder}/"
    return Outcome(
        outcome.kind,
        outcome.text.replace(prefix, ""),
        outcome.at,
        outcome.detail.replace(prefix, ""),
    )


def line_without_folder(line: LogLine, folder: Path) -> LogLine:
    return LogLine(line.time, line.level, line.text.replace(f"{folder}/", ""))


def not_run(simulation: Simulation, outcome: Outcome) -> Recording:
    """Return the recording of a scenario in which no node ran."""
    return Recording(
        scenario=simulation.scenario,
        layout=simulation.layout,
        seed=simulation.seed,
        duration_s=0.0,
        delivered=(),
        published=(),
        truth=simulation.truth(),
        outcome=outcome,
        endpoints=(),
    )
