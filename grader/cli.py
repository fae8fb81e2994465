"""The command `course`: list the exercises, grade, drive, and check recordings."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from grader.errors import GraderError, InputError

if TYPE_CHECKING:
    from grader.grading.grading import Grading
    from grader.recording import Recording

FULL, LESS, FAULT = 0, 1, 2  # exit codes
JSON_STDOUT = "-"

LIST_EXAMPLES = """\b
Examples:
  course list
"""
GRADE_EXAMPLES = """\b
Examples:
  course grade obstacle_avoidance my_agent.py
  course grade goal_seeking my_folder --field --report report.html
  course grade 1 my_agent.py --only stop_zone --json -
"""
DRIVE_EXAMPLES = """\b
Examples:
  course drive my_agent.py --scenario demo_wall
  course drive my_agent.py --scenario demo_wall --lidar lds01 --report drive.html
  course drive seeker.py --scenario demo_open --goal 5 3 --goal 0 0 --param gain:=0.5
  course drive slow_agent.py --scenario demo_wall --charge-compute
"""
DATASET_EXAMPLES = """\b
Examples:
  course dataset train.npz
  course dataset more.npz --seed 7 --scans 5000
"""
CHECK_BAG_EXAMPLES = """\b
Examples:
  course grade goal_seeking my_seeker.py --bags bags
  course check-bag bags/goal_origin_to_5_3 goal_seeking
  course check-bag bags goal_seeking
"""
AUTOGRADE_EXAMPLES = """\b
Examples:
  course autograde handed_in --out graded --workers 4
  course autograde handed_in --out graded --exercise 1 --field --secret course.secret
  course autograde handed_in --out graded --regrade
"""
RELEASE_EXAMPLES = """\b
Examples:
  course release for_students
  course release week_1 --exercise obstacle_avoidance --student-package
"""


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(package_name="rclpy-agents-course", prog_name="course")
def cli() -> None:
    """Grade ROS 2 nodes written in Python, in a mock robot, in virtual time."""


@cli.command("list", epilog=LIST_EXAMPLES)
def list_() -> None:
    """List the exercises."""
    from rich.console import Console  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415

    from grader.course.exercises import all_exercises  # noqa: PLC0415

    table = Table(box=None, padding=(0, 2, 0, 0), header_style="bold")
    for heading in ("#", "Exercise", "File", "What it is about"):
        table.add_column(heading)
    for exercise in all_exercises():
        files = ", ".join(exercise.files)
        table.add_row(str(exercise.number), exercise.slug, files, exercise.summary)
    Console().print(table)


@cli.command(epilog=GRADE_EXAMPLES)
@click.argument("exercise")
@click.argument("file", metavar="FILE|FOLDER", type=click.Path(path_type=Path))
@click.option(
    "--tier", type=click.IntRange(1, 2), default=1, help="1: virtual time; 2: real time, on DDS."
)
@click.option("--field", is_flag=True, help="Run the field checks too (badge, no points).")
@click.option("--only", multiple=True, metavar="CHECK", help="Run this check and what it needs.")
@click.option("--seed", type=click.IntRange(0, 10**6), help="Vary worlds and noise.")
@click.option("--student", metavar="ID", help="Use this student's own worlds; needs --secret.")
@click.option("--secret", type=click.Path(path_type=Path), help="File with the course's secret.")
@click.option("--json", "json_", metavar="PATH|-", help="Write the result as JSON; -: to stdout.")
@click.option("--report", type=click.Path(path_type=Path), help="Write an HTML report.")
@click.option("--bags", type=click.Path(path_type=Path), help="Save every trial as a bag here.")
def grade(
    exercise: str,
    file: Path,
    tier: int,
    field: bool,
    only: tuple[str, ...],
    seed: int | None,
    student: str | None,
    secret: Path | None,
    json_: str | None,
    report: Path | None,
    bags: Path | None,
) -> int:
    """Grade a node: EXERCISE by name or number, FILE or a FOLDER that holds it.

    Exit code 0: full core score. 1: less. 2: wrong usage, or the grader's own fault.
    """
    from grader.course.exercises import find_exercise  # noqa: PLC0415
    from grader.course.submission import find_submission  # noqa: PLC0415

    chosen = find_exercise(exercise)
    first = file.with_name(chosen.files[0])
    if file.name in chosen.files[1:] and first.is_file():
        file = first  # whichever file is given, the exercise's first one is the node
    submission = find_submission(file, chosen.files[0], chosen.files[1:])
    if student is not None or secret is not None:
        seed = _student_seed(student, secret, chosen.slug, seed)
    _check_writable(report, json_)
    with _forkserver(chosen.libraries) as forkserver:
        from grader.grading.grading import grade_submission  # noqa: PLC0415

        grading = grade_submission(
            chosen,
            submission,
            forkserver,
            file=str(file),
            field=field,
            only=only,
            seed=seed,
            bags=bags,
            tier=tier,
        )
    _show(grading, json_, report)
    return _exit_code(grading)


@cli.command(epilog=DRIVE_EXAMPLES)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--scenario", required=True, metavar="NAME|PATH", help="A scenario or its TOML file.")
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
    "--charge-compute", is_flag=True,
    help="Computing takes time: the node's CPU time is added to the clock, in ms. Runs then depend "
    "on the machine, so no grading does it.",
)  # fmt: skip
@click.option("--seed", type=click.IntRange(0, 10**6), help="Vary world and noise.")
@click.option("--report", type=click.Path(path_type=Path), help="Write an HTML replay.")
@click.option("--bag", type=click.Path(path_type=Path), help="Save the drive as a bag.")
def drive(
    file: Path,
    scenario: str,
    lidar: str | None,
    duration: float | None,
    goals: tuple[tuple[float, float], ...],
    params: tuple[str, ...],
    remappings: tuple[str, ...],
    params_files: tuple[Path, ...],
    stdin: str | None,
    charge_compute: bool,
    seed: int | None,
    report: Path | None,
    bag: Path | None,
) -> int:
    """Run any rclpy node in the mock robot, without grading."""
    from grader import drive as driving  # noqa: PLC0415
    from grader.course.submission import find_submission  # noqa: PLC0415

    arguments = driving.arguments_of(params, remappings, params_files)
    chosen = driving.scenario_for(scenario, lidar=lidar, duration=duration, goals=goals)
    own = [program.file for program in chosen.program if not program.supplied]
    submission = find_submission(file, others=[name for name in own if name])
    taken = [path.name for path in (submission.path, *submission.others)]
    files = driving.read_params_files(params_files, taken)
    text = driving.read_stdin(stdin)
    _check_writable(report, None)
    with _forkserver() as forkserver:
        recording = driving.drive_node(
            submission,
            chosen,
            forkserver,
            seed=seed,
            arguments=arguments,
            files=files,
            stdin=text,
            charge_compute=charge_compute,
        )
    if bag is not None:
        from grader.recording.bag import save  # noqa: PLC0415

        save(recording, bag)
    driving.print_summary(recording, file=str(file), charged=charge_compute)
    if report is not None:
        _write_report(report, None, [recording], f"Drive of {file.name}")
    return FULL if recording.outcome.completed else LESS


@cli.command(epilog=DATASET_EXAMPLES)
@click.argument("out", type=click.Path(path_type=Path))
@click.option("--seed", type=click.IntRange(0, 10**6), default=1, help="Other rooms, other scans.")
@click.option("--scans", type=click.IntRange(100, 100_000), default=2000, help="How many.")
def dataset(out: Path, seed: int, scans: int) -> int:
    """Make data to learn from: OUT.npz with scans of the mock lidar and an expert's speeds."""
    from grader.models.dataset import make_dataset  # noqa: PLC0415

    if out.suffix != ".npz":
        raise InputError(f"{out}: expected a name that ends in .npz")
    _check_writable(out, None)
    made = make_dataset(scans, seed)
    made.save(out)
    standing = 100 * float((made.speed == 0.0).mean())
    click.echo(f"{out}: {scans} scans; in {standing:.0f} % of them the expert stands still")
    return FULL


@cli.command("check-bag", epilog=CHECK_BAG_EXAMPLES)
@click.argument("bag", type=click.Path(path_type=Path))
@click.argument("exercise")
@click.option("--only", multiple=True, metavar="CHECK", help="Run this check and what it needs.")
@click.option("--field", is_flag=True, help="Run the field checks too.")
@click.option("--json", "json_", metavar="PATH|-", help="Write the result as JSON; -: to stdout.")
@click.option("--report", type=click.Path(path_type=Path), help="Write an HTML report.")
def check_bag(
    bag: Path,
    exercise: str,
    only: tuple[str, ...],
    field: bool,
    json_: str | None,
    report: Path | None,
) -> int:
    """Judge saved recordings: BAG is one bag, or a folder of them. No student code runs."""
    from grader.course.exercises import find_exercise  # noqa: PLC0415
    from grader.grading.grading import grade as grade_recordings  # noqa: PLC0415
    from grader.trial.trials import SavedTrials, load_bags  # noqa: PLC0415

    chosen = find_exercise(exercise)
    _check_writable(report, json_)
    trials = SavedTrials(load_bags(bag))
    grading = grade_recordings(chosen, trials, file=str(bag), field=field, only=only)
    _show(grading, json_, report)
    return _exit_code(grading)


@cli.command()
def doctor() -> int:
    """Say what this machine offers: ROS, libraries, and the layers around students' code.

    Exit code 0: nodes can run here, and other people's code may be graded. 1: only one's own. 2: no
    node can run.
    """
    from rich.console import Console  # noqa: PLC0415

    from grader.link.doctor import diagnose  # noqa: PLC0415
    from grader.report.terminal import render_diagnosis  # noqa: PLC0415

    found = diagnose()
    render_diagnosis(found, Console())
    if found.problem:
        return 2
    return 1 if found.foreign_code else 0


@cli.command(epilog=AUTOGRADE_EXAMPLES)
@click.argument("submissions", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Results, and state.")
@click.option("--exercise", "exercises", multiple=True, metavar="EXERCISE", help="Only this one.")
@click.option(
    "--workers", type=click.IntRange(1, 256), default=1, help="Processes on this machine."
)
@click.option("--dask", default="", metavar="ADDRESS|FILE", help="Use a Dask cluster's workers.")
@click.option("--secret", type=click.Path(path_type=Path), help="Each student's own worlds.")
@click.option("--field", is_flag=True, help="Run the field checks too (badge, no points).")
@click.option("--regrade", is_flag=True, help="Judge stored recordings again; runs no nodes.")
@click.option("--retry-held", is_flag=True, help="Grade again what was held after a try.")
@click.option("--no-bags", is_flag=True, help="Keep no recordings: no replays, no --regrade.")
@click.option("--trust", is_flag=True, help="Run submissions even where isolation is too weak.")
@click.option("--canaries", type=click.IntRange(0, 10_000), default=25, metavar="N",
              help="Grade known solutions every N submissions; 0: never.")  # fmt: skip
@click.option("--hide", default="nothing", help="From students: nothing, field, worlds, details.")
def autograde(
    submissions: Path,
    out: Path,
    exercises: tuple[str, ...],
    workers: int,
    dask: str,
    secret: Path | None,
    field: bool,
    regrade: bool,
    retry_held: bool,
    no_bags: bool,
    trust: bool,
    canaries: int,
    hide: str,
) -> int:
    """Grade a class: SUBMISSIONS holds a folder or an archive per student.

    Run it again after anything: it goes on where it was, and grades only what is new or changed.
    Exit code 0: all graded. 1: some are held for a person. 2: wrong usage, or the grader's fault.
    """
    from rich.console import Console  # noqa: PLC0415

    from grader.classroom.batch import Options  # noqa: PLC0415
    from grader.classroom.batch import autograde as grade_class  # noqa: PLC0415
    from grader.classroom.progress import ConsoleProgress, summary  # noqa: PLC0415
    from grader.classroom.results import ResultOptions  # noqa: PLC0415
    from grader.course.students import read_secret  # noqa: PLC0415

    ResultOptions(hide=hide)  # refuses unknown words before the work
    options = Options(
        exercises=exercises,
        workers=workers,
        dask=dask,
        secret=None if secret is None else read_secret(secret),
        field=field,
        bags=not no_bags,
        trust=trust,
        canaries=canaries,
        hide=hide,
        retry_held=retry_held,
    )
    console = Console()
    with ConsoleProgress(console) as progress:
        results = grade_class(submissions, out, options, progress, regrade=regrade)
    lines, held = summary(results, out)
    console.print(lines, markup=False, highlight=False, soft_wrap=True)
    return LESS if held else FULL


@cli.command(epilog=RELEASE_EXAMPLES)
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--exercise", "exercises", multiple=True, metavar="EXERCISE", help="Only this one.")
@click.option("--student-package", is_flag=True, help="Make DIR.zip too, for `pip install`.")
@click.option(
    "--plain", is_flag=True, help="No notebooks, and the lesson as Markdown: needs no Sphinx."
)
def release(folder: Path, exercises: tuple[str, ...], student_package: bool, plain: bool) -> int:
    """Write into DIR what students get: no solutions, no rubrics, no tests.

    That is the lesson as a site, the skeletons, the notebooks, the public scenarios and the grader.
    """
    from grader.authoring.handouts import handouts  # noqa: PLC0415
    from grader.authoring.release import release as make_release  # noqa: PLC0415
    from grader.course.exercises import find_exercise  # noqa: PLC0415

    slugs = [find_exercise(name).slug for name in exercises]
    make = None if plain else handouts
    for leak in make_release(folder, exercises=slugs, archive=student_package, make=make):
        click.echo(f"Note: {leak}; hand it out after that exercise (--exercise).", err=True)
    click.echo(f"Students' material: {folder}")
    if student_package:
        click.echo(f"The same, packed: {folder}.zip")
    return FULL


for _command, _room in {"autograde": "classroom", "release": "authoring"}.items():
    if not Path(__file__).with_name(_room).exists():
        cli.commands.pop(_command, None)  # the students' package does without


def main() -> None:
    """Run the command; errors take one line."""
    try:
        code = cli.main(standalone_mode=False)
        sys.stdout.flush()
    except BrokenPipeError:  # `course … | head`; links to hosts never raise it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = LESS
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        code = FAULT
    except click.exceptions.Abort:
        code = _say("interrupted")
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        command = context.command_path if context else "course"
        code = _say(f"{error.format_message()} (see {command} --help)")
    except (InputError, GraderError) as error:
        code = _say(str(error))
    except KeyboardInterrupt:
        code = _say("interrupted")
    except OSError as error:
        code = _say(f"{error.filename or 'file'}: {error.strerror}")
    sys.exit(code if isinstance(code, int) else 0)


def _say(message: str) -> int:
    line = " ".join(message.split())
    click.echo(f"course: {line}", err=True)
    return FAULT


def _student_seed(student: str | None, secret: Path | None, slug: str, seed: int | None) -> int:
    from grader.course.students import read_secret, student_seed  # noqa: PLC0415

    if student is None or secret is None:
        raise InputError("--student and --secret go together")
    if seed is not None:
        raise InputError("--seed and --student exclude each other")
    return student_seed(read_secret(secret), student, slug)


def _forkserver(libraries: tuple[str, ...] = ()) -> Any:
    """Start the process that will run the node, as early as possible: it warms up meanwhile."""
    from grader.link.hosts import ForkServer  # noqa: PLC0415
    from sim.messages import EPOCH_NS  # noqa: PLC0415

    return ForkServer(EPOCH_NS, libraries=libraries)


def _check_writable(report: Path | None, json_: str | None) -> None:
    """Find out before the work that its result can't be written."""
    for target in (report, Path(json_) if json_ and json_ != JSON_STDOUT else None):
        if target is not None and not target.resolve().parent.is_dir():
            raise InputError(f"{target}: its folder does not exist")
        if target is not None and target.is_dir():
            raise InputError(f"{target}: expected a file to write, but this is a folder")
        if target is not None and not target.exists():
            target.touch()  # an OSError says what is wrong
            target.unlink()


def _show(grading: Grading, json_: str | None, report: Path | None) -> None:
    from grader.report.page import json_text, render_terminal  # noqa: PLC0415

    result = grading.as_dict()
    if json_ == JSON_STDOUT:
        sys.stdout.write(json_text(result))
    else:
        from rich.console import Console  # noqa: PLC0415

        render_terminal(result, Console())
    if json_ and json_ != JSON_STDOUT:
        Path(json_).write_text(json_text(result), "utf-8")
    if report is not None:
        title = f"{grading.exercise.title}: {Path(grading.file).name}"
        _write_report(report, result, list(grading.recordings), title, quiet=bool(json_))


def _write_report(
    path: Path,
    grading: dict[str, Any] | None,
    recordings: list[Recording],
    title: str,
    quiet: bool = False,
) -> None:
    from grader.report.page import page_html, page_payload  # noqa: PLC0415

    path.write_text(page_html(page_payload(grading, recordings, title)), "utf-8")
    if not quiet:
        click.echo(f"Report with replays: {path}")


def _exit_code(grading: Grading) -> int:
    if grading.faulty:
        return FAULT
    return FULL if grading.full else LESS


if __name__ == "__main__":
    main()
