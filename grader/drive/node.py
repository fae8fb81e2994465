"""Drive any rclpy node in the mock robot: the scenario with changes, arguments, files."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import msgspec

from grader.course.submission import Submission, file_beside, read_regular_file
from grader.errors import InputError
from grader.models.files import OWN
from grader.recording import Recording
from grader.trial.hangs import busy_wait
from grader.trial.packages import unpacked
from grader.trial.seeds import mixed_seed
from grader.trial.training import MAX_FILE
from grader.trial.virtual_time import Limits, run_trial
from rclpy_virtual_time import Launcher, Start
from sim.lidar import PROFILES
from sim.scenario import Scenario, ScriptEvent, Transforms
from sim.scenario_files import load_scenario

FIRST_GOAL = 0.5  # [s]
NEITHER = ", and not in real time either"
PATIENCE = Limits(start=10.0, step=2.0, total=20.0)  # a node that hangs does so again and again ...
SECOND_LOOK = Limits(total=60.0)  # ... and one that a busy machine kept waiting does not
PARAMETER = re.compile(r"[A-Za-z_][\w.]*:=.+")
VARIABLE = re.compile(r"[A-Za-z_]\w{0,99}=[^\0]{0,1000}", re.ASCII | re.DOTALL)  # NAME=VALUE
ESCAPE = re.compile(r"\\(?:x[0-9a-fA-F]{2}|[nrt\\])")
REMAPPING = re.compile(r"[^\s:]+(:[^\s:=]+)?:=\S+")  # FROM:=TO, also NODE:FROM:=TO


def scenario_for(
    name: str,
    *,
    lidar: str | None = None,
    duration: float | None = None,
    goals: Sequence[tuple[float, float]] = (),
) -> Scenario:
    """Return a scenario, changed as asked.

    Raises InputError: there is no such scenario or profile.

    Parameters
    ----------
    lidar
        Another lidar profile.
    duration
        Another duration [s].
    goals
        Goals [m] to send instead of the scenario's own: the first at 0.5 s, the others spread over
        the drive.
    """
    scenario = load_scenario(name)
    changes: dict[str, object] = {"transforms": Transforms(enabled=True)}  # for nodes with tf2
    if lidar is not None:
        if lidar not in PROFILES:
            raise InputError(f"unknown lidar profile {lidar!r}; there are: {', '.join(PROFILES)}")
        changes["lidar"] = msgspec.structs.replace(scenario.lidar, profile=lidar, rate=None)
    if duration is not None:
        if not math.isfinite(duration) or duration <= 0:
            raise InputError(f"--duration {duration}: expected a time in seconds, such as 20")
        changes["duration"] = duration
    if goals:
        total = duration or scenario.duration
        kept = tuple(event for event in scenario.script if event.goal is None)
        sent = tuple(
            ScriptEvent(at=FIRST_GOAL + i * total / len(goals), goal=(x, y, 0.0))
            for i, (x, y) in enumerate(goals)
        )
        changes["script"] = kept + sent
    return msgspec.structs.replace(scenario, **changes)


def arguments_of(
    params: Sequence[str], remappings: Sequence[str] = (), params_files: Sequence[Path] = ()
) -> list[str]:
    """Return the command line that sets ROS parameters and remaps names.

    Raises InputError: one is not of that form.

    Parameters
    ----------
    params
        Each NAME:=VALUE.
    remappings
        Each FROM:=TO.
    params_files
        YAML files; they must lie in the node's folder under their names (see `drive_node`).
    """
    for param in params:
        if not PARAMETER.fullmatch(param):
            raise InputError(f"--param {param!r}: expected NAME:=VALUE, such as max_speed:=0.3")
    for rule in remappings:
        if not REMAPPING.fullmatch(rule):
            raise InputError(f"-r {rule!r}: expected FROM:=TO, such as /scan:=/lidar/scan")
    flags = [word for rule in remappings for word in ("-r", rule)]
    flags += [word for file in params_files for word in ("--params-file", file.name)]
    flags += [word for param in params for word in ("-p", param)]
    return ["--ros-args", *flags] if flags else []


def read_params_files(paths: Sequence[Path], taken: Sequence[str]) -> dict[str, bytes]:
    """Return the parameter files to put beside the node: name and content.

    Raises InputError: one can't be read, or two files would have the same name there; `taken` are
    the node's.
    """
    found: dict[str, bytes] = {}
    for path in paths:
        if path.name in (*found, *taken):
            raise InputError(f"--params-file {path}: another file has the same name; rename it")
        found[path.name] = _content(path, "--params-file")
    return found


def read_stdin(source: str | None) -> bytes:
    """Return the text for the node's stdin: a file's content; "-": this process's stdin.

    Raises InputError: the file can't be read, or it is too long.
    """
    if source is None:
        return b""
    data = sys.stdin.buffer.read() if source == "-" else _content(Path(source), "--stdin")
    if len(data) > Start.MAX_STDIN:
        raise InputError(f"--stdin {source}: {len(data)} bytes, expected at most {Start.MAX_STDIN}")
    return data


def read_keys(text: str) -> bytes:
    """Return the keys of a text, in which Enter and arrows are written as in Python.

    Raises InputError: there are too many, or none on this system.
    """
    if sys.platform == "win32" and text:
        raise InputError("--keys: Windows has no terminals of this kind; --stdin FILE works there")
    keys = ESCAPE.sub(lambda found: found[0].encode().decode("unicode_escape"), text).encode()
    if len(keys) > Start.MAX_KEYS:
        raise InputError(f"--keys: {len(keys)} bytes, expected at most {Start.MAX_KEYS}")
    return keys


def read_env(settings: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """Return names and values of environment variables.

    Raises InputError: one is not NAME=VALUE.
    """
    for setting in settings:
        if not VARIABLE.fullmatch(setting):
            raise InputError(
                f"--env {setting!r}: expected NAME=VALUE, such as TURTLEBOT3_MODEL=burger"
            )
    found = [setting.partition("=") for setting in settings]
    return tuple((name, value) for name, _, value in found)


def _content(path: Path, option: str) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{option} {path}: {error.strerror}") from None


def drive_node(
    submission: Submission,
    scenario: Scenario,
    launcher: Launcher,
    *,
    seed: int | None = None,
    arguments: Sequence[str] = (),
    files: Mapping[str, bytes] | None = None,
    stdin: bytes = b"",
    keys: bytes = b"",
    env: Sequence[tuple[str, str]] = (),
    charge_compute: bool = False,
    stamped: bool = True,
    limits: Limits | None = None,
    interrupt: bool = True,
    lead: int = 0,
    look: Sequence[float] = (),
    on_second_look: Callable[[], None] | None = None,
) -> Recording:
    """Run the node once; `stamped`: the robot also understands TwistStamped.

    `files` (name and content) are laid beside the node; the rest is as in `run_trial`. Where
    `on_second_look` is given, it is called, and the node runs again in real time, if that may
    carry what virtual time can't, such as a loop without a wait.

    If a scenario uses the student's own model, it is taken from the node's folder.
    """
    limits = limits or (Limits(start=10.0) if on_second_look else None)
    submission = unpacked(submission, launcher)
    own = [name for name, model in scenario.node.models.items() if model.probe == OWN]
    beside = [file for name in own if (file := file_beside(submission.path, name)) is not None]
    mixed = mixed_seed(scenario, seed)
    laid = {path.name: read_regular_file(path, MAX_FILE) for path in beside} | dict(files or {})
    recording = run_trial(
        submission,
        scenario,
        launcher,
        seed=mixed,
        arguments=arguments,
        stamped=stamped,
        files=laid,
        stdin=stdin,
        keys=keys,
        env=env,
        charge_compute=charge_compute,
        limits=limits,
        interrupt=interrupt,
        lead=lead,
        look=look,
    )
    hung = recording.outcome.kind == "hung"
    special = launcher.practice or stdin or keys or env or charge_compute  # there is none of it
    if on_second_look is None or special or not (hung or recording.outcome.kind == "real_time"):
        return recording
    from grader.trial.real_time import run_live_trial  # noqa: PLC0415  (Linux only)
    from rclpy_virtual_time import ForkServer  # noqa: PLC0415  (as before)

    on_second_look()
    assert isinstance(launcher, ForkServer)
    real = run_live_trial(
        submission, scenario, launcher, seed=mixed, arguments=arguments, files=laid,
        reason=busy_wait(recording) if hung else recording.outcome.text,
        stamped=stamped, lenient=True,
    )  # fmt: skip
    if hung and not real.published and (real.outcome.kind == "hung" or not real.delivered):
        outcome = replace(recording.outcome, text=f"{recording.outcome.text}{NEITHER}")
        return replace(recording, outcome=outcome, endpoints=recording.endpoints or real.endpoints)
    return real


def drive_in(submission: Submission, scenario: Scenario, launcher: Launcher) -> Recording:
    """Drive a node as `course drive --scenario` does, but with less patience at first."""
    with_frames = msgspec.structs.replace(scenario, transforms=Transforms(enabled=True))
    for limits in (PATIENCE, SECOND_LOOK):
        recording = drive_node(submission, with_frames, launcher, limits=limits, interrupt=False)
        if recording.outcome.kind not in ("hung", "slow"):
            break
    return recording
