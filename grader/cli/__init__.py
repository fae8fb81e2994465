"""The command `course`. Each of its commands has a module here, which imports what it runs."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence
from pathlib import Path

# A judge's arrays are small; OpenBLAS's threads would wait for large ones, at full speed.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import click

from grader.cli import (
    autograde,
    begin,
    check_bag,
    dataset,
    desk,
    doctor,
    drive,
    exercises,
    grade,
    marks,
    new,
    race,
    release,
    report,
    search,
    why,
)
from grader.cli.gone import what_replaces
from grader.cli.results import FAULT, LESS
from grader.errors import GraderError, InputError
from grader.report.echo import echo

GRADER = Path(__file__).resolve().parents[1]


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(package_name="rclpy-agents-course", prog_name="course")
def cli() -> None:
    """Grade ROS 2 nodes written in Python, in a mock robot, in virtual time."""


for _command in (
    exercises.list_,
    begin.start,
    grade.grade,
    begin.next_,
    begin.progress_,
    why.why,
    drive.drive,
    race.race,
    search.search,
    dataset.dataset,
    check_bag.check_bag,
    doctor.doctor,
):
    cli.add_command(_command)
for _command, _room in (
    (autograde.autograde, "classroom"),
    (marks.marks, "classroom"),
    (report.report, "classroom"),
    (desk.desk, "classroom"),
    (release.release, "authoring"),
    (new.new, "authoring"),
):
    if (GRADER / _room).exists():  # the students' package has neither
        cli.add_command(_command)


def main() -> None:
    """Run the command with the arguments of this process; SIGTERM ends it as Ctrl-C does."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    sys.exit(run())


def run(arguments: Sequence[str] | None = None, elsewhere: drive.Elsewhere | None = None) -> int:
    """Run the command and return its exit code; errors take one line.

    A page drives `elsewhere`.
    """
    try:
        if said := what_replaces(sys.argv[1:] if arguments is None else arguments):
            return _complain(said)
        code = cli.main(arguments, "course", standalone_mode=False, obj=elsewhere)
        sys.stdout.flush()
    except BrokenPipeError:  # `course … | head`; links to hosts never raise it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = LESS
    except click.exceptions.NoArgsIsHelpError as error:
        echo(error.format_message(), err=True)
        code = FAULT
    except click.exceptions.Abort:
        code = _complain("interrupted")
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        command = context.command_path if context else "course"
        code = _complain(f"{error.format_message()} (see {command} --help)")
    except InputError as error:
        code = _complain(*str(error).split("\n"))
    except GraderError as error:
        code = _complain(str(error))
    except KeyboardInterrupt:
        code = _complain("interrupted")
    except OSError as error:
        code = _complain(f"{error.filename or 'file'}: {error.strerror}")
    return code if isinstance(code, int) else 0


def _complain(message: str, *choices: str) -> int:
    """Print a line, and a line for each name to choose from."""
    lines = (" ".join(message.split()), *(f"  {' '.join(choice.split())}" for choice in choices))
    echo("course: " + "\n".join(lines), err=True)
    return FAULT
