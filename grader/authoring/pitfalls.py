"""Make the replays and the quoted texts of lessons/pitfalls: plausible nodes that fail, and why.

Each pitfall is a node in lessons/pitfalls/nodes that looks right and is not, and the same node put
right. Their jobs are other and smaller ones than the exercises': they are published, and nobody
should pass with one of them. `python -m grader.authoring.pitfalls OUT` drives them and writes a
replay of each into OUT, which opens where it goes wrong. `--made` writes lessons/pitfalls/made:
the differences, the frames of the replays, and what the grader says of wrong solutions
(solutions/*/mutants.toml) that make the same mistakes; `--check` tells whether that is up to date.
"""

from __future__ import annotations

import difflib
import html
import io
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from grader.authoring.mutants import find_mutant
from grader.checks.obstacle_avoidance.contract import front_distance
from grader.checks.obstacle_avoidance.evidence import answers, spell
from grader.course.exercises import ROOT, find_exercise
from grader.course.submission import find_submission
from grader.errors import GraderError, InputError
from grader.grading.grading import Grading, grade_submission
from grader.link.hosts import ForkServer
from grader.models.features import possible_features
from grader.models.files import probe
from grader.recording import Recording
from grader.report.page import GENERATED_BY, page_html, render_terminal, replay_payload
from grader.trial.virtual_time import run_trial
from sim.messages import CMD_VEL_TOPIC, EPOCH_NS, TWIST_STAMPED
from sim.scenario import load_scenario

FOLDER = ROOT / "lessons" / "pitfalls"
NODES = FOLDER / "nodes"
MADE = FOLDER / "made"
FRAME = ("replay.css", "replay.js")  # of the pages: copied beside the replays
MODES = ("--made", "--check")
REPLAYS = "replays"  # where a page looks for them, seen from itself
WIDTH = 80  # [characters] of the grader's tables
AHEAD = 45.0  # [°] to both sides is ahead, for the nodes that stop for a wall
STOP = 0.8  # [m] nearer than this they stop
MAX_SPEED = 0.5  # [m/s] of the nodes with a model
SILENCE = 10  # scans or commands, and still the robot stands
TURNS_ON = 0.3  # [rad/s] is no longer looking for its heading
LIBRARIES = re.compile(r"\S*/(?:site|dist)-packages/")  # where they are differs by machine

JsonDict = dict[str, Any]


@dataclass(frozen=True)
class Moment:
    """Where a run goes wrong."""

    t: float  # [s]
    rule: str  # that is broken
    expected: str
    actual: str

    def as_dict(self) -> JsonDict:
        """Return what the player shows."""
        return {
            "t": round(self.t, 3), "check": "", "title": self.rule, "outcome": "fail",
            "message": "", "expected": self.expected, "actual": self.actual, "help": "",
        }  # fmt: skip


Moments = Callable[[Recording], Iterator[Moment]]


# --- where it goes wrong --------------------------------------------------------------------------


def does_not_stop(recording: Recording) -> Iterator[Moment]:
    """Drives on although something is less than 0.8 m ahead."""
    for answer in answers(recording):
        distance = front_distance(answer.scan, AHEAD)
        if distance is not None and distance < STOP and answer.speed:
            yield Moment(
                answer.scan.t,
                f"Closer than {STOP} m the robot stands still.",
                f"linear.x = 0.00 m/s: {distance:.2f} m ahead",
                f"linear.x = {spell(answer.speed)} m/s",
            )
            break
    yield from touches(recording)


def mistakes_the_model(off: float, *columns: int) -> Moments:
    """Commands a speed that is `off` [m/s] from what the model says of the right features.

    The model is fed these columns of exercise 2's features.
    """

    def moments(recording: Recording) -> Iterator[Moment]:
        (model,) = (probe(model) for model in recording.scenario.node.models.values())
        for answer in answers(recording):
            rows = possible_features(answer.scan)[:, list(columns)]
            right = np.clip(model.predict(rows), 0.0, MAX_SPEED)
            said = float("nan") if answer.speed is None else answer.speed
            if not right.min() - off <= said <= right.max() + off:
                yield Moment(
                    answer.scan.t,
                    "The speed is what the model says.",
                    f"linear.x = {(right.min() + right.max()) / 2:.2f} m/s",
                    f"linear.x = {spell(said)} m/s",
                )
                break
        yield from touches(recording)

    return moments


def turns_past_the_goal(recording: Recording) -> Iterator[Moment]:
    """Looks at the goal, and turns on."""
    twists, odometry, goals = recording.twists(), recording.odometry(), recording.goals()
    if not len(goals.t):
        return
    at = np.searchsorted(odometry.t, twists.t, side="right") - 1
    bearing = np.arctan2(goals.y[0] - odometry.y[at], goals.x[0] - odometry.x[at])
    error = np.remainder(bearing - odometry.yaw[at] + np.pi, 2 * np.pi) - np.pi
    past = error * twists.angular_z < 0.0
    wrong = np.flatnonzero(past & (np.abs(twists.angular_z) > TURNS_ON))
    if len(wrong):
        i = int(wrong[0])
        yield Moment(
            float(twists.t[i]),
            "It turns until it faces the goal.",
            f"hardly any turning: the heading error is {error[i]:+.2f} rad",
            f"angular.z = {twists.angular_z[i]:+.2f} rad/s",
        )


def falls_silent(recording: Recording) -> Iterator[Moment]:
    """Does not answer a scan, and the robot goes on with its last command."""
    truth = recording.truth
    for answer in answers(recording):
        if answer.count:
            continue
        speed = float(np.interp(answer.scan.t, truth.t / 1e9, truth.v))
        yield Moment(
            answer.scan.t,
            "Without a model every scan is answered by a stop.",
            "a Twist with linear.x = 0.00 m/s",
            f"nothing on /cmd_vel; the robot rolls on at {speed:.2f} m/s",
        )
        break
    yield from touches(recording)


def speaks_another_type(recording: Recording) -> Iterator[Moment]:
    """Commands come in a type that the robot does not listen to."""
    said = [m for m in recording.of(CMD_VEL_TOPIC) if m.type == TWIST_STAMPED]
    if len(said) >= SILENCE:
        yield Moment(
            said[SILENCE - 1].time / 1e9,
            "The robot does what the node says.",
            "geometry_msgs/msg/Twist on /cmd_vel",
            f"{SILENCE} times geometry_msgs/msg/TwistStamped, and the robot stands",
        )


def hears_nothing(recording: Recording) -> Iterator[Moment]:
    """Scans are sent, and none is heard."""
    deaf = [end for end in recording.endpoints if end.topic == "/scan" and end.mismatch]
    scans = recording.scans()
    if deaf and len(scans) >= SILENCE and not recording.of(CMD_VEL_TOPIC):
        yield Moment(
            scans[SILENCE - 1].t,
            "Each scan is answered by a Twist.",
            f"{SILENCE} commands by now",
            f"none: {deaf[0].mismatch}",
        )


def touches(recording: Recording) -> Iterator[Moment]:
    """Runs into something."""
    truth = recording.truth
    if truth.contact.any():
        at = truth.t[int(np.argmax(truth.contact))] / 1e9
        yield Moment(float(at), "The robot touches nothing.", "a stop before that", "contact")


# --- the pitfalls ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Pitfall:
    """A mistake: nodes that make it, a node that does not, and who catches it."""

    name: str  # of its page
    wrong: tuple[str, ...]  # nodes
    right: str  # node
    exercise: str
    caught: Mapping[str, tuple[str, ...]]  # wrong solutions: the checks that its page quotes
    scenario: str  # in which it shows
    moments: Moments

    @property
    def nodes(self) -> tuple[str, ...]:
        """All of its nodes."""
        return (*self.wrong, self.right)


PITFALLS = (
    Pitfall(
        "front_by_index",
        ("front_by_index_wrong",),
        "front_by_index_right",
        "obstacle_avoidance",
        {"obstacle_avoidance/hard_coded_indices": ("field_lds01",)},
        "avoid_field_lds01",
        does_not_stop,
    ),
    Pitfall(
        "left_right_swapped",
        ("left_right_swapped_wrong",),
        "left_right_swapped_right",
        "ml_velocity",
        {"ml_velocity/left_is_negative": ("left_min", "right_min")},
        "demo_cart_from_the_left",
        mistakes_the_model(0.2, 3, 4),
    ),
    Pitfall(
        "nan_through_clip",
        ("nan_through_clip_wrong", "nan_through_minmax_wrong"),
        "nan_through_clip_right",
        "ml_velocity",
        {
            "ml_velocity/infinity_stays_infinite": ("infinite_readings",),
            "ml_velocity/nan_slips_through": ("not_finite",),
        },
        "demo_yard",
        mistakes_the_model(0.1, 0, 1, 2),
    ),
    Pitfall(
        "heading_without_yaw",
        ("heading_without_yaw_wrong",),
        "heading_without_yaw_right",
        "goal_seeking",
        {"goal_seeking/heading_without_yaw": ("reaches_goal", "turns_short_way")},
        "demo_point",
        turns_past_the_goal,
    ),
    Pitfall(
        "no_stop_without_model",
        ("no_stop_without_model_wrong",),
        "no_stop_without_model_right",
        "ml_velocity",
        {"ml_velocity/no_command_without_a_model": ("no_model",)},
        "demo_new_model",
        falls_silent,
    ),
    Pitfall(
        "twist_stamped",
        ("twist_stamped_wrong",),
        "twist_stamped_right",
        "obstacle_avoidance",
        {"obstacle_avoidance/twist_stamped": ("wiring",)},
        "avoid_wall",
        speaks_another_type,
    ),
    Pitfall(
        "reliable_only",
        ("reliable_only_wrong",),
        "reliable_only_right",
        "obstacle_avoidance",
        {"obstacle_avoidance/reliable_only": ("field_best_effort",)},
        "avoid_field_best_effort",
        hears_nothing,
    ),
)


# --- replays --------------------------------------------------------------------------------------


def main(arguments: list[str]) -> int:
    """Write the replays, or the texts; with `--check` compare the texts, 1 if they are not so."""
    if len(arguments) != 1 or (arguments[0].startswith("-") and arguments[0] not in MODES):
        raise InputError(f"expected a folder for the replays, or {' or '.join(MODES)}")
    with ForkServer(EPOCH_NS) as forkserver:
        if arguments[0] not in MODES:
            write_replays(Path(arguments[0]), forkserver)
            return 0
        texts = dict(made(forkserver))
    if arguments == ["--check"]:
        stale = [file.name for file, text in texts.items() if _text_of(file) != text]
        if stale:
            command = "python -m grader.authoring.pitfalls --made"
            print(f"{', '.join(stale)}: not up to date: run `{command}`")
        return 1 if stale else 0
    MADE.mkdir(exist_ok=True)
    for file, text in texts.items():
        file.write_text(text, "utf-8")
    return 0


def write_replays(out: Path, forkserver: ForkServer) -> None:
    """Drive every node and write its replay, and what frames the replays in a page."""
    out.mkdir(parents=True, exist_ok=True)
    for name in FRAME:
        shutil.copyfile(FOLDER / name, out / name)
    for pitfall in PITFALLS:
        for node in pitfall.nodes:
            recording = drive(pitfall, node, forkserver)
            (out / f"{node}.html").write_text(replay(pitfall, recording), "utf-8")


def drive(pitfall: Pitfall, node: str, forkserver: ForkServer) -> Recording:
    """Run a node in the pitfall's scenario; the robot takes nothing but Twist."""
    submission = find_submission(NODES / f"{node}.py")
    return run_trial(submission, load_scenario(pitfall.scenario), forkserver)


def replay(pitfall: Pitfall, recording: Recording) -> str:
    """Return the replay, a page for a frame; it opens at the first moment, if there is one."""
    moments = [moment.as_dict() for moment in pitfall.moments(recording)]
    shown = replay_payload(recording, moments)
    for line in shown["log"]:
        line["text"] = LIBRARIES.sub("", line["text"].replace(f"{ROOT}/", ""))
    shown["compute"] = []  # of this machine, and beside the page's point
    payload = {
        "grading": None, "replays": [shown], "title": shown["title"],
        "generated_by": GENERATED_BY, "embedded": True,
    }  # fmt: skip
    return page_html(payload)


# --- texts ----------------------------------------------------------------------------------------


def made(
    forkserver: ForkServer, pitfalls: Iterable[Pitfall] = PITFALLS
) -> Iterator[tuple[Path, str]]:
    """Return every file of lessons/pitfalls/made with its text."""
    for pitfall in pitfalls:
        yield MADE / f"{pitfall.name}.diff", differences(pitfall.wrong[0], pitfall.right)
        for mutant, checks in pitfall.caught.items():
            said = printed(grade_mutant(mutant, forkserver, only=checks))
            yield MADE / f"{Path(mutant).name}.grade.txt", said
        for node in pitfall.nodes:
            shown = frame(pitfall, drive(pitfall, node, forkserver), node)
            yield MADE / f"{node}.frame.txt", shown


def grade_mutant(mutant: str, forkserver: ForkServer, *, only: Iterable[str] = ()) -> Grading:
    """Grade a wrong solution, `exercise/name`, by some checks or by all, as if it were handed in.

    Raises
    ------
    GraderError
        The grader or the machine failed.
    """
    slug, _, name = mutant.partition("/")
    exercise = find_exercise(slug)
    wrong = find_mutant(exercise, name)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, wrong.file)
        file.write_text(wrong.text, "utf-8")
        return grade(slug, file, forkserver, only=only)


def grade(slug: str, path: Path, forkserver: ForkServer, *, only: Iterable[str] = ()) -> Grading:
    """Grade a node, by some checks or by all of the core.

    Raises
    ------
    GraderError
        The grader or the machine failed.
    """
    only = tuple(only)
    grading = grade_submission(
        find_exercise(slug),
        find_submission(path),
        forkserver,
        file=path.name,
        field=any(check.startswith("field_") for check in only),
        only=only,
    )
    if grading.faulty:
        raise GraderError(f"{path.name} could not be judged; try again")
    return grading


def printed(grading: Grading) -> str:
    """Return what `course grade … --only …` prints, without colour."""
    text = io.StringIO()
    console = Console(file=text, width=WIDTH, color_system=None, force_terminal=False)
    render_terminal(grading.as_dict(), console)
    lines = [line.rstrip() for line in text.getvalue().strip("\n").splitlines()]
    return "\n".join(lines).replace("\n\n\n", "\n\n") + "\n"


def differences(wrong: str, right: str) -> str:
    """Return how to put a wrong node right, as a unified diff."""
    before, after = (
        (NODES / f"{node}.py").read_text("utf-8").splitlines(keepends=True)
        for node in (wrong, right)
    )
    return "".join(difflib.unified_diff(before, after, f"{wrong}.py", f"{right}.py", n=2))


def frame(pitfall: Pitfall, recording: Recording, node: str) -> str:
    """Return a replay's place in a page: HTML, with a caption."""
    first = next(pitfall.moments(recording), None)
    what = "wrong" if node in pitfall.wrong else "right"
    title = f"Replay of {node}.py: {recording.scenario.title}"
    source = f"{REPLAYS}/{node}.html"
    said = "The node put right, from the start."
    if first is not None:
        said = (
            f"Stopped at {first.t:.2f} s, where this fails: “{first.rule}” "
            f"Expected: {first.expected}. Actual: {first.actual}."
        )
    return (
        f'<figure class="replay is-{what}">\n'
        f'<iframe loading="lazy" title="{html.escape(title)}" src="{source}"></iframe>\n'
        f"<figcaption>{html.escape(said)}\n"
        f'<a href="{source}">Open it on a page of its own</a></figcaption>\n'
        "</figure>\n"
    )


def _text_of(file: Path) -> str:
    return file.read_text("utf-8") if file.is_file() else ""


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
