"""Build what a release does not just copy: the lesson's site and the students' notebooks."""

import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

from grader.course.exercises import ROOT, all_exercises
from grader.errors import GraderError, InputError
from grader.nbgrader.cells import definition

SITE = "lesson"  # folder of the site in a release
NOTEBOOKS = "notebooks"
LIMIT = 600.0  # [s] for each of the programs that build them; they take seconds
NEEDED = {  # module: the extra that brings it
    "sphinx": "site", "myst_parser": "site", "furo": "site",
    "nbgrader": "notebooks", "jupytext": "notebooks",
}  # fmt: skip


def handouts(
    left_out: Collection[str] = (), *, answers: bool = True, ways: bool = False
) -> dict[str, bytes]:
    """Return the site's and the notebooks' files by their paths in a release.

    Raises InputError: Sphinx or nbgrader is not installed.
    Raises GraderError: one of them failed.

    Parameters
    ----------
    left_out
        Slugs of exercises that are not released: their notebooks are left out, too. The site
        is one lesson and has the tasks of all, but no skeletons of these.
    answers
        The site has model answers to its open questions.
    ways
        Its workspaces have others' ways, as far as `make ways` has made them.
    """
    require_tools()
    with tempfile.TemporaryDirectory(prefix="course-handouts-") as name:
        pages = site(Path(name), left_out, answers=answers, ways=ways)
        return pages | without(notebooks(Path(name)), left_out)


def require_tools() -> None:
    """Make sure that the tools for the site and the notebooks are installed.

    Raises InputError: some are not; the message says which, and what to do.
    """
    missing = [module for module in NEEDED if importlib.util.find_spec(module) is None]
    if missing:
        extras = ",".join(dict.fromkeys(NEEDED[module] for module in missing))
        raise InputError(
            f"the lesson's site and the notebooks can't be built: {', '.join(missing)} "
            f"{'is' if len(missing) == 1 else 'are'} not installed; "
            f"pip install --editable '.[{extras}]', or hand out the plain pages with --plain"
        )


def site(
    work: Path, left_out: Collection[str] = (), *, answers: bool = True, ways: bool = False
) -> dict[str, bytes]:
    """Return the lesson as `make site` builds it, replays included."""
    out = work / SITE
    _run(
        "-m", "sphinx", "-q", "-W", "--keep-going", "-n", "-b", "html",
        "-D", f"course_left_out={','.join(sorted(left_out))}",
        "-D", f"course_model_answers={answers:d}",
        *(() if ways else ("-D", "course_ways=")),
        "-d", str(work / "doctrees"), str(ROOT / "lessons"), str(out),
    )  # fmt: skip
    _run("-m", "grader.authoring.pitfalls", str(out / "pitfalls" / "replays"))
    _run("-m", "grader.authoring.lesson_replays", str(out / "replays"))
    return {f"{SITE}/{path.relative_to(out).as_posix()}": data for path, data in _files(out)}


def notebooks(work: Path) -> dict[str, bytes]:
    """Return the notebooks as `nbgrader generate_assignment` releases them."""
    from grader.notebook.build import NOTEBOOKS as COURSE  # noqa: PLC0415  (Jupyter: 1 s)
    from grader.notebook.build import files  # noqa: PLC0415

    course = work / "course"
    for path, text in files(course / "source"):
        path.parent.mkdir(parents=True)
        path.write_text(text, "utf-8")
    shutil.copyfile(COURSE / "nbgrader_config.py", course / "nbgrader_config.py")
    _run("-m", "nbgrader", "generate_assignment", "*", "--no-db", cwd=course)  # all of them
    return {f"{NOTEBOOKS}/{path.name}": data for path, data in _files(course / "release")}


def without(notebooks: Mapping[str, bytes], left_out: Collection[str]) -> dict[str, bytes]:
    """Return the notebooks without those of these exercises (slugs)."""
    files = {name for e in all_exercises() if e.slug in left_out for name in e.files}
    return {path: data for path, data in notebooks.items() if files.isdisjoint(made_by(data))}


def made_by(notebook: bytes) -> set[str]:
    """Return the files that the cells of a notebook (its JSON) write."""
    cells = json.loads(notebook)["cells"]
    made = [definition("".join(cell["source"])) for cell in cells if cell["cell_type"] == "code"]
    return {one.file for one in made if one is not None}


def _files(folder: Path) -> Iterator[tuple[Path, bytes]]:
    """Yield the files below a folder, without hidden ones (Sphinx's bookkeeping)."""
    for path in sorted(folder.rglob("*")):
        if path.is_file() and not any(
            part.startswith(".") for part in path.relative_to(folder).parts
        ):
            yield path, path.read_bytes()


def _run(*arguments: str, cwd: Path = ROOT) -> None:
    """Run this Python with these arguments, without the user's Jupyter settings."""
    paths = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]  # of a sourced ROS
    with tempfile.TemporaryDirectory(prefix="course-jupyter-") as settings:
        environment = {
            **os.environ, "JUPYTER_CONFIG_DIR": settings, "PYTHONPATH": os.pathsep.join(paths),
        }  # fmt: skip
        try:
            done = subprocess.run(
                [sys.executable, *arguments],
                cwd=cwd, env=environment, capture_output=True, text=True,
                timeout=LIMIT, check=False,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            raise GraderError(f"{arguments[1]} took longer than {LIMIT:.0f} s") from None
    if done.returncode:
        said = (done.stderr or done.stdout).strip()
        raise GraderError(f"{arguments[1]} failed: {said[-1500:]}")
