"""Gradescope's autograder as a zip: the grader, a script that sets it up, one that runs it.

It has what students get and the rooms that take submissions in, and no solution. A course's secret
and the settings are in it, so it is for the instructor alone.

Source: Gradescope, "Autograder Specifications": the zip is unpacked to /autograder/source, setup.sh
runs once as root when the image is built, run_autograder for each submission.
"""

import json
import tempfile
from collections.abc import Collection, Sequence
from pathlib import Path

from grader.authoring.leaks import leaks
from grader.authoring.release import contents, pack
from grader.course.exercises import all_exercises, find_exercise
from grader.errors import GraderError, InputError

NAME = "autograder.zip"
# What students don't get and an autograder needs
ROOMS = ("grader/classroom", "grader/models/expert.py")
DEEP = ("torch", "keras")  # libraries of exercise 8
PROGRAM, PLAIN, PRIVATE = 0o100755, 0o100644, 0o100600

SETUP = """\
#!/usr/bin/env bash
# Runs once, as root, when Gradescope builds the image: a Python with the course in it.
set -euo pipefail
umask 022
export DEBIAN_FRONTEND=noninteractive
source="${AUTOGRADER_ROOT:-/autograder}/source"
course="${COURSE_HOME:-/opt/course}"  # students' nodes read it, so it lies outside of source

fits='import sys, ensurepip; sys.exit(not (3, 11) <= sys.version_info < (3, 15))'
suitable() {  # the first Python that fits, with venv
    local each
    for each in python3.12 python3.13 python3.14 python3.11 python3; do
        if "$each" -c "$fits" 2>/dev/null; then
            command -v "$each"
            return
        fi
    done
    return 1
}

add() {  # a Python of the distribution's own packages
    local version
    for version in 3.12 3.13 3.14 3.11; do
        if apt-get install -y --no-install-recommends "python$version" "python$version-venv"; then
            return
        fi
    done
    return 1
}

if ! suitable >/dev/null; then
    apt-get update
    if ! add; then  # Ubuntu 22.04 and older have none
        apt-get install -y --no-install-recommends software-properties-common
        add-apt-repository -y ppa:deadsnakes/ppa
        apt-get update
        add
    fi
fi
python="$(suitable)" || { echo "expected a Python from 3.11 to 3.14, found none" >&2; exit 1; }

rm -rf "$course/source" "$course/venv"
mkdir -p "$course"
cp -r "$source/course" "$course/source"
"$python" -m venv "$course/venv"
pip() { "$course/venv/bin/python" -m pip --disable-pip-version-check --no-cache-dir "$@"; }
{torch}pip install --quiet --constraint "$course/source/constraints.txt" \\
    --editable "$course/source[{extras}]"
"$course/venv/bin/course" doctor
echo "An empty submission, to see that there is a result:"
trial="$(mktemp -d)"
mkdir "$trial/source" "$trial/submission"
cp "$source/autograder.json" "$trial/source"
AUTOGRADER_ROOT="$trial" COURSE_HOME="$course" bash "$source/run_autograder"
test -s "$trial/results/results.json"
rm -r "$trial"
chmod -R go-rwx "$source"
"""
# Without it pip fetches gigabytes of CUDA.
TORCH = """\
pip install --quiet --constraint "$course/source/constraints.txt" \\
    --extra-index-url https://download.pytorch.org/whl/cpu torch
"""
RUN = """\
#!/usr/bin/env bash
# Runs for each submission; grader/classroom/autograder.py says what it does.
exec "${COURSE_HOME:-/opt/course}/venv/bin/python" -I -m grader.classroom.autograder \\
    "${AUTOGRADER_ROOT:-/autograder}"
"""


def write_autograder(
    folder: Path,
    *,
    exercises: Collection[str] = (),
    field: bool = False,
    hide: Sequence[str] = (),
    secret: Path | None = None,
) -> Path:
    """Write Gradescope's autograder into `folder`; return the zip.

    Raises InputError: `folder` is not empty, or the secret can't be read.
    Raises GraderError: a piece of a solution would have been in it.

    Parameters
    ----------
    folder
        Must not exist, or be empty.
    exercises
        Slugs of the exercises of the assignment; all if empty.
    field, hide
        As for `course autograde`.
    secret
        File with the course's secret: each student gets different worlds.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(f"{folder}: expected a new or empty folder; choose another")
    chosen = [each for each in all_exercises() if not exercises or each.slug in exercises]
    slugs = [exercise.slug for exercise in chosen]
    deep = any(not {*DEEP}.isdisjoint(exercise.libraries) for exercise in chosen)
    course = contents(slugs, rooms=ROOMS)
    _check(course)
    settings = {"exercises": slugs, "field": field, "hide": list(hide)}
    files = [
        ("setup.sh", setup(deep=deep).encode(), PROGRAM),
        ("run_autograder", RUN.encode(), PROGRAM),
        ("autograder.json", (json.dumps(settings, indent=2) + "\n").encode(), PRIVATE),
        *((f"course/{path}", data, PLAIN) for path, data in course.items()),
    ]
    if secret is not None:
        try:
            files.append(("course.secret", secret.read_bytes(), PRIVATE))
        except OSError as error:
            raise InputError(f"{secret}: cannot read the secret ({error.strerror})") from None
    folder.mkdir(parents=True, exist_ok=True)
    pack(folder / NAME, files, mode=0o600)  # it may hold the secret
    return folder / NAME


def setup(*, deep: bool) -> str:
    """Return setup.sh; with PyTorch and Keras if `deep`."""
    extras = "ros,ml,deep" if deep else "ros,ml"
    return SETUP.replace("{torch}", TORCH if deep else "").replace("{extras}", extras)


def _check(course: dict[str, bytes]) -> None:
    """Make sure that no piece of a solution is in it: students' nodes run beside it."""
    with tempfile.TemporaryDirectory(prefix="course-autograder-") as name:
        for path, data in course.items():
            target = Path(name, path)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(data)
        wrong = [leak for leak in leaks(Path(name)) if not leak.earlier]
    if wrong:
        raise GraderError(f"no autograder was written: {wrong[0]}")


def total_points(slugs: Collection[str]) -> int:
    """Return the points of the assignment, for Gradescope's settings."""
    chosen = map(find_exercise, slugs) if slugs else all_exercises()
    return sum(exercise.max_points for exercise in chosen)
