"""`course release`: write what students get."""

from __future__ import annotations

from pathlib import Path

import click

from grader.cli.results import FULL

EXAMPLES = """\b
Examples:
  course release for_students
  course release week_1 --exercise obstacle_avoidance --student-package
"""


@click.command(epilog=EXAMPLES)
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
    from grader.authoring.handouts import handouts, stay_behind  # noqa: PLC0415
    from grader.authoring.release import release as make_release  # noqa: PLC0415
    from grader.course.exercises import all_exercises, find_exercise  # noqa: PLC0415

    slugs = [find_exercise(name).slug for name in exercises]
    make = None if plain else handouts
    for leak in make_release(folder, exercises=slugs, archive=student_package, make=make):
        click.echo(f"Note: {leak}; hand it out after that exercise (--exercise).", err=True)
    left_out = {e.slug for e in all_exercises() if slugs and e.slug not in slugs}
    for said in () if plain else stay_behind(left_out):
        click.echo(f"Note: {said}.", err=True)
    click.echo(f"Students' material: {folder}")
    if student_package:
        click.echo(f"The same, packed: {folder}.zip")
    return FULL
