"""`course drive`: run one node, without judging it."""

from __future__ import annotations

import contextlib
import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from grader.cli.given import as_files, wanted_in
from grader.cli.results import FULL, LESS, check_writable, write_report
from grader.cli.start import portable_option, start_forkserver
from grader.errors import InputError
from grader.report.echo import echo

if TYPE_CHECKING:
    from grader.recording import Recording
    from rclpy_virtual_time import Launcher

EXAMPLES = """\b
Examples:
  course drive my_agent.py --scenario demo_wall
  course drive my_agent.py --scenario demo_wall --lidar lds01 --report drive.html
  course drive seeker.py --scenario demo_open --goal 5 3 --goal 0 0 --param gain:=0.5
  course drive slow_agent.py --scenario demo_wall --charge-compute
  course drive my_agent.py --scenario demo_wall --at 4.2 --at 4.3
"""


@dataclass(frozen=True)
class Elsewhere:
    """How a lesson's page drives: in its own process, without a word about practice."""

    launcher: Launcher
    drive_node: Callable[..., Recording]  # as grader.drive's


@click.command(epilog=EXAMPLES)
@click.argument("file", metavar="FILE|FOLDER", type=click.Path(path_type=Path))
@click.option("--scenario", metavar="NAME|PATH", help="A scenario or its TOML file. Needed.")
@click.option("--lidar", metavar="PROFILE", help="default, lds01, lds02 or wide.")
@click.option("--duration", type=click.FloatRange(0.1, 3600), metavar="S", help="Simulated time.")
@click.option(
    "--goal", "goals", type=(float, float), multiple=True, metavar="X Y",
    help="Send this goal [m]; several are spread over the drive.",
)  # fmt: skip
@click.option("--param", "params", multiple=True, metavar="NAME:=VALUE", help="A ROS parameter.")
@click.option("-r", "remappings", multiple=True, metavar="FROM:=TO", help="Remap a name.")
@click.option(
    "--params-file", "params_files", multiple=True, type=click.Path(path_type=Path),
    help="ROS parameters in YAML; the file is copied beside the node.",
)  # fmt: skip
@click.option("--stdin", metavar="FILE|-", help="What the node reads from stdin, as by input().")
@click.option(
    "--keys", default="", metavar="TEXT",
    help=r"Type this to the node, a key every half second: wwad, or \x1b[A for an arrow.",
)  # fmt: skip
@click.option("--env", multiple=True, metavar="NAME=VALUE", help="An environment variable.")
@click.option(
    "--charge-compute", is_flag=True,
    help="Computing takes time: the node's CPU time is added to the clock, in ms. Runs then depend "
    "on the machine, so no grading does it.",
)  # fmt: skip
@click.option(
    "--at", "at", type=click.FloatRange(0, 3600), multiple=True, metavar="S",
    help="Show the callback that began last by then, to the hundredth shown: what came, what the "
    "node kept, what it sent and its locals there; of several programs each one's. Given twice: "
    "side by side.",
)  # fmt: skip
@click.option("--callback", default="", metavar="NAME", help="With --at: of this function.")
@click.option(
    "--log", "log", metavar="N|all", default="10", help="Lines of what the node said to show."
)
@click.option("--seed", type=click.IntRange(0, 10**6), help="Vary world and noise.")
@click.option("--report", type=click.Path(path_type=Path), help="Write an HTML replay.")
@click.option("--bag", type=click.Path(path_type=Path), help="Save the drive as a bag.")
@portable_option
def drive(
    file: Path,
    scenario: str | None,
    lidar: str | None,
    duration: float | None,
    goals: tuple[tuple[float, float], ...],
    params: tuple[str, ...],
    remappings: tuple[str, ...],
    params_files: tuple[Path, ...],
    stdin: str | None,
    keys: str,
    env: tuple[str, ...],
    charge_compute: bool,
    at: tuple[float, ...],
    callback: str,
    log: str,
    seed: int | None,
    report: Path | None,
    bag: Path | None,
    portable: bool,
) -> int:
    """Run any rclpy node in the mock robot, without grading.

    FILE is a Python file, which runs as with python3, a launch file, a colcon package's folder, a
    notebook with %%node cells, or a zip of one of these. What lies beside it comes along; links do
    not.
    """
    from grader import drive as driving  # noqa: PLC0415
    from grader.course.submission import find_submission  # noqa: PLC0415
    from rclpy_virtual_time import Link  # noqa: PLC0415

    context = click.get_current_context()
    elsewhere: Elsewhere | None = context.obj
    if scenario is None:
        raise InputError(
            "--scenario NAME: expected one, such as --scenario demo_wall; "
            "`course list --scenarios` lists them all"
        )
    arguments = driving.arguments_of(params, remappings, params_files)
    chosen = driving.scenario_for(scenario, lidar=lidar, duration=duration, goals=goals)
    own = [program.file for program in chosen.program if not program.supplied]
    names = wanted_in(chosen.name)
    given = file if elsewhere else context.with_resource(as_files(file, names))
    submission = find_submission(given, others=[name for name in own if name])
    taken = [path.name for path in (submission.path, *submission.others)]
    files = driving.read_params_files(params_files, taken)
    text = driving.read_stdin(stdin)
    typed, variables = driving.read_keys(keys), driving.read_env(env)
    if text and typed:
        raise InputError("--stdin and --keys: expected one of them; a node has one stdin")
    driving.check_moments(at, chosen)
    if callback and not at:
        raise InputError("--callback NAME: expected --at S with it, the moment to look at")
    if at and charge_compute:
        raise InputError("--at and --charge-compute: expected one; looking takes CPU time, too")
    if log != "all" and not log.isdecimal():
        raise InputError(f"--log {log!r}: expected a number of lines, or all")
    check_writable(report)
    drive_node = elsewhere.drive_node if elsewhere else driving.drive_node
    with (
        contextlib.nullcontext(elsewhere.launcher)
        if elsewhere
        else start_forkserver((Link.Moment.LIBRARY,) if at else (), portable=portable)
    ) as forkserver:
        submission = driving.unpacked(submission, forkserver)
        if submission.problem:
            raise InputError(f"{file}: {submission.problem}")
        recording = drive_node(
            submission,
            chosen,
            forkserver,
            seed=seed,
            arguments=arguments,
            files=files,
            stdin=text,
            keys=typed,
            env=variables,
            charge_compute=charge_compute,
            look=at,
            on_second_look=lambda: echo(
                f"{file.name}: not in virtual time; once more in real time, which takes its start "
                f"and {chosen.duration:.0f} s",
                err=True,
            ),
        )
    if bag is not None:
        from grader.recording.bag import save  # noqa: PLC0415
        from sim.messages import typestore  # noqa: PLC0415

        save(recording, bag)
        if own := {each.type for each in recording.published} - typestore().fielddefs.keys():
            echo(f"{bag}: without {', '.join(own)}: a bag has ROS's own types alone", err=True)
    practice = "" if elsewhere else forkserver.practice
    driving.print_summary(
        recording, file=str(file), seed=seed, practice=practice,
        most=None if log == "all" else int(log),
        rest=driving.IN_REPLAY if elsewhere else "--log all shows them all",
    )  # fmt: skip
    for said in submission.account():
        echo(textwrap.fill(f"  {said}", 80, subsequent_indent="  ", break_on_hyphens=False))
    driving.print_moments(recording, at, callback)
    if report is not None:
        write_report(report, None, [recording], f"Drive of {file.name}")
    outcome = recording.outcome
    return FULL if outcome.completed or outcome.by_itself else LESS
