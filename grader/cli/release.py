"""`course release`: write what students get."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path, PurePath

import click

from grader.cli.results import FULL
from grader.errors import InputError
from grader.report.echo import echo

EXAMPLES = """\b
Examples:
  course release for_students
  course release week_1 --exercise 1 --student-package
  course release template --classroom --exercise 1 --plain
  course release upload --gradescope --exercise 1 --secret course.secret
"""


@click.command(epilog=EXAMPLES)
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--exercise", "exercises", multiple=True, metavar="EXERCISE", help="Only this one.")
@click.option("--student-package", is_flag=True, help="Make DIR.zip too, for `pip install`.")
@click.option("--classroom", is_flag=True, help="Add GitHub Classroom's workflow.")
@click.option("--gradescope", is_flag=True, help="Write an autograder for Gradescope instead.")
@click.option(
    "--secret",
    type=click.Path(path_type=Path),
    help="With --gradescope: each student gets different worlds.",
)
@click.option("--field", is_flag=True, help="With --gradescope: run the field checks too.")
@click.option("--hide", metavar="WHAT", help="With --gradescope: as for `course autograde`.")
@click.option(
    "--source", default="", metavar="ADDRESS", help="Where notebooks get the course's wheel."
)
@click.option(
    "--no-answers", is_flag=True, help="The lesson without model answers: you grade its questions."
)
@click.option(
    "--ways", is_flag=True, help="The site with solutions of others, for after full marks."
)
@click.option(
    "--plain", is_flag=True, help="No notebooks, and the lesson as Markdown: needs no Sphinx."
)
def release(
    folder: Path,
    exercises: tuple[str, ...],
    student_package: bool,
    classroom: bool,
    gradescope: bool,
    secret: Path | None,
    field: bool,
    hide: str | None,
    source: str,
    no_answers: bool,
    ways: bool,
    plain: bool,
) -> int:
    """Write into DIR what students get: no solutions, no rubrics, no tests.

    That is the lesson as a site, the skeletons, the notebooks, the public scenarios and the grader.
    """
    from grader.authoring import github  # noqa: PLC0415
    from grader.authoring.carried import built_wheel, carried, what_lacks  # noqa: PLC0415
    from grader.authoring.handouts import handouts  # noqa: PLC0415
    from grader.authoring.release import drafts  # noqa: PLC0415
    from grader.authoring.release import release as make_release  # noqa: PLC0415
    from grader.course.exercises import ROOT, all_exercises, find_exercise  # noqa: PLC0415

    if not (ROOT / "solutions").is_dir():
        raise InputError(f"{ROOT}: expected a checkout of the course, with solutions/ in it")
    slugs = [find_exercise(name).slug for name in exercises]
    if gradescope:
        if student_package or classroom or plain or source or no_answers or ways:
            raise InputError("--gradescope writes nothing for students; leave the others out")
        return _autograder(folder, slugs, field, hide, secret)
    if secret is not None or field or hide is not None:
        raise InputError("--secret, --field and --hide go with --gradescope")
    if plain and source:
        raise InputError("--source is for notebooks, which --plain leaves out")
    if plain and no_answers:
        raise InputError("--no-answers is for the site, which --plain leaves out")
    if ways and (plain or not (ROOT / "build" / "ways").is_dir()):
        raise InputError("--ways is for the site, which --plain leaves out; `make ways` first")
    wheel = built_wheel()

    def make(left: Collection[str]) -> dict[str, bytes]:
        workspace = (ROOT / "build" / "workspace").is_dir()
        lacks = "nodes can't be written in the site's pages: make workspace first"
        for lack in filter(None, (what_lacks(wheel, source), "" if workspace else lacks)):
            echo(f"Note: {lack}.", err=True)
        echo("Building the lesson's site and the notebooks takes a minute or two …", err=True)
        made = handouts(left, answers=not no_answers, ways=ways)
        echo("Built. Looking for what gives a solution away …", err=True)
        return carried(made, wheel, source)

    released = [each for each in all_exercises() if not slugs or each.slug in slugs]
    more = github.files(released) if classroom else {}
    found = make_release(
        folder, exercises=slugs, archive=student_package, make=None if plain else make, more=more
    )
    for draft in drafts():
        echo(f"Note: {draft} stays here: git does not know it.", err=True)
    for of in sorted({leak.of for leak in found}):
        places = {leak.file.partition(", cell")[0] for leak in found if leak.of == of}
        files = ", ".join(sorted({PurePath(place).name for place in places}))
        echo(f"Note: {of}'s solution is partly in {files}; hand that out after it.", err=True)
    echo(f"Students' material: {folder}")
    if student_package:
        echo(f"The same, packed: {folder}.zip")
    return FULL


def _autograder(
    folder: Path, slugs: list[str], field: bool, hide: str | None, secret: Path | None
) -> int:
    from grader.authoring.gradescope import total_points, write_autograder  # noqa: PLC0415
    from grader.classroom.results.options import ResultOptions  # noqa: PLC0415
    from grader.course.students import read_secret  # noqa: PLC0415

    if secret is not None:
        read_secret(secret)  # refused now, not in Gradescope
    hidden = ResultOptions(hide=hide or ("worlds" if secret else "nothing")).hidden
    written = write_autograder(
        folder, exercises=slugs, field=field, hide=sorted(hidden), secret=secret
    )
    echo(f"Gradescope's autograder: {written}")
    echo(f"The assignment's autograder points: {total_points(slugs)}")
    if secret is not None:
        echo("It holds the course's secret: keep it from students.")
    return FULL
