"""Make what students get: lesson, skeletons, notebooks, the robot and the grader, but no answers.

What goes in is listed here, so a new file stays with the instructor until somebody adds it. Before
anything is written, the release is searched for pieces of every solution.
"""

import re
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from pathlib import Path, PurePosixPath

from grader.authoring.leaks import Leak, leaks
from grader.course.exercises import ROOT, SOLUTIONS, all_exercises
from grader.errors import GraderError, InputError

# Folders and files for instructors and contributors; not in the students' copy.
INSTRUCTORS = (
    "grader/authoring", "grader/claims", "grader/classroom", "grader/course/generated.py",
    "grader/course/skeletons.py", "grader/models/expert.py", "grader/notebook/build.py",
    "rclpy_virtual_time/conform", "rclpy_virtual_time/tests", "rclpy_virtual_time/setup.py",
)  # fmt: skip
PACKAGE = (".xml", ".cfg", ".yaml", ".rviz")  # suffixes of the files of a ROS package
MARKER = "resource"  # folder with a ROS package's marker file, which has no suffix
LESSONS = "lessons"
MADE = ("build", "dist", "_ros")  # folders that are made when they are needed
KEPT = {
    "sim": (".py", ".toml", *PACKAGE),
    "grader": (".py", ".toml", ".xml", ".js", ".css", ".html", ".npz", ".json"),
    "exercises": (".py", ".md", ".toml", *PACKAGE),
    "rclpy_virtual_time": (".py", ".xml"),
    "rclpy_portable": (".py",),
    LESSONS: (".md", ".png", ".svg"),
}
SINGLE = (
    "LICENSE", "LICENSE-lessons.md", "constraints.txt",
    "Dockerfile", ".dockerignore", ".devcontainer/devcontainer.json",
    "docs/students.md", "docs/testing-your-node.md", "docs/search.md", "docs/live-robot.md",
    "docs/portable.md",
    "docs/images/notebook-dark.png", "docs/images/notebook-light.png",
    "docs/images/notebook-wrong.png",
)  # fmt: skip
PRIVATE = re.compile(
    r"(?i)(^|[_\-.])(secrets?|hidden|solutions?|mutants?|variants?|private)([_\-.]|$)"
)
QUIZ = "lessons/quiz.md"  # its tables are the rubric

BACKEND = 'build-backend = "course_setup"\nbackend-path = ["."]'
SETUP = '''\
"""Make the command `course`: `python3 course_setup.py`, on Windows `py course_setup.py`.

For pip it is setuptools, with words of its own for a Python that is too old.
"""

import sys

if sys.version_info < (3, 11):
    said = "expected Python 3.11 to 3.14, but this is %d.%d; take a newer one"
    sys.exit(said % sys.version_info[:2])


def make():
    """Make .venv beside this file, with the course in it."""
    import os
    import subprocess
    from pathlib import Path

    here = Path(__file__).resolve().parent
    programs = here / ".venv" / ("Scripts" if os.name == "nt" else "bin")
    print("Installing the course into .venv: two or three minutes.", flush=True)
    pip = [programs / "python", "-m", "pip", "--disable-pip-version-check", "install", "--quiet"]
    course = ["--constraint", here / "constraints.txt", "--editable", f"{here}[ros]"]
    for command in ([sys.executable, "-m", "venv", here / ".venv"], [*pip, *course]):
        if subprocess.run(command).returncode:
            sys.exit("That failed; the lines above say why. Mend it, and run this once more.")
    try:
        shown = (programs / "course").relative_to(Path.cwd())
    except ValueError:
        shown = programs / "course"
    print(f"Next: {shown} start")


if __name__ == "__main__":
    make()
else:
    from setuptools.build_meta import *  # noqa: F403
'''
STAMP = (2020, 1, 1, 0, 0, 0)  # time of every file in the archive: same release, same bytes

README = """\
# Bridging Python agents with rclpy: for students

Write ROS 2 nodes in Python and let them drive a mock robot. You need Python 3.11 to 3.14; no robot,
and no ROS installation. Three commands, in this folder: the first makes the command `course`, in
a few minutes; the second a folder for you; the third grades it.

**macOS**, in a terminal (and Linux):

    python3 course_setup.py
    .venv/bin/course start {number}
    .venv/bin/course grade {number} {slug}

**Windows**, in PowerShell:

    py course_setup.py
    .venv\\Scripts\\course start {number}
    .venv\\Scripts\\course grade {number} {slug}

**Linux** on x86_64, with Python up to 3.14, gets the real rclpy of ROS 2. If `venv` is missing:
`sudo apt install python3-venv`. macOS, Windows and ARM get [a portable one](docs/portable.md), for
practice. It has never been tried there yet: please tell your instructor what you see.

**A cloud notebook** (Colab, Kaggle, …): {cloud}

Now open `README.md` in the new folder: it says what your node has to do. The skeleton beside it has
no points yet, and the grader says what to do first. Grade after each change; `course next` says how
to go on. So that `course` alone is enough, type `source .venv/bin/activate` in each new terminal,
on Windows `.venv\\Scripts\\activate`. Later exercises want more libraries: the grader says which.
[docs/students.md](docs/students.md) has the rest. Where ROS 2 is installed, `exercises/` and `sim/`
are packages for `colcon build`, too.

{lesson}

| # | Exercise | What it is about |
|---|---|---|
{rows}

Code: Apache-2.0 (`LICENSE`). Lesson text: CC BY 4.0 (`LICENSE-lessons.md`).
"""


WITH_SITE = """\
The lesson is a site that needs no network: open `lesson/index.html`. To work in notebooks here, in
the activated environment: `pip install jupyterlab matplotlib`, then `jupyter lab notebooks`."""
PLAIN = "The lesson begins with `lessons/index.md`."
CLOUD = """\
upload a notebook of `notebooks/` and the wheel that lies
beside it, and run the first cell."""
NO_CLOUD = "the three commands work in its terminal, as on Linux."

Make = Callable[[Collection[str]], Mapping[str, bytes]]


def release(
    folder: Path,
    *,
    exercises: Collection[str] = (),
    archive: bool = False,
    make: Make | None = None,
    more: Mapping[str, bytes] | None = None,
) -> list[Leak]:
    """Write the students' material into `folder`; return the skeletons that hold earlier answers.

    Raises InputError: `folder` (or the archive) exists already; or `make` raised it.
    Raises GraderError: a piece of a solution would have been released.

    Parameters
    ----------
    folder
        Must not exist, or be empty.
    exercises
        Slugs of the exercises to release; all if empty.
    archive
        Also write `FOLDER.zip`, the same bytes each time; `pip install` takes either.
    make
        Builds the lesson's site and the notebooks, given the exercises that are left out (see
        `grader.authoring.handouts`). Without it there are no notebooks, and the lesson is released
        as Markdown.
    more
        Other files by their paths.
    """
    packed = folder.with_name(folder.name + ".zip")
    _check_free(folder, packed if archive else None)
    files = contents(exercises, ROOT, make) | dict(more or {})
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent, prefix=".release-") as name:
        staged = Path(name) / "course"
        for path, data in files.items():
            target = staged / path
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(data)
        found = leaks(staged, SOLUTIONS)
        wrong = [leak for leak in found if not leak.earlier]
        if wrong:
            raise GraderError(f"nothing was released: {wrong[0]}" + _and_more(len(wrong) - 1))
        if archive:
            pack(packed, [(f"{folder.name}/{path}", data, 0o644) for path, data in files.items()])
        if folder.is_dir():
            folder.rmdir()  # empty, as was checked
        shutil.move(staged, folder)
    return found


def contents(
    exercises: Collection[str] = (),
    root: Path = ROOT,
    make: Make | None = None,
    rooms: Collection[str] = (),
) -> dict[str, bytes]:
    """Return every file of a release by its path, in order; with these of `INSTRUCTORS`."""
    known = [exercise.slug for exercise in all_exercises()]
    left_out = {slug for slug in known if exercises and slug not in exercises}
    found = {path: (root / path).read_bytes() for path in SINGLE if (root / path).is_file()}
    unknown = _unknown_to_git(root)
    for room, suffixes in KEPT.items():
        if make is not None and room == LESSONS:
            continue  # its site goes out
        for file in _walk(root / room):
            path = file.relative_to(root).as_posix()
            if (
                _is_kept(file, suffixes)
                and _is_public(path, left_out, rooms)
                and path not in unknown
            ):
                found[path] = file.read_bytes()
    if QUIZ in found:
        found[QUIZ] = questions(found[QUIZ].decode("utf-8")).encode()
    if make is not None:
        found.update(make(left_out))
    found["pyproject.toml"] = _pyproject((root / "pyproject.toml").read_text("utf-8")).encode()
    found["course_setup.py"] = SETUP.encode()
    found["README.md"] = _readme(left_out, plain=make is None).encode()
    return dict(sorted(found.items()))


def drafts(root: Path = ROOT) -> list[str]:
    """Return the files that would be released if somebody had added them to git."""
    unknown = _unknown_to_git(root)
    found = (each.relative_to(root).as_posix() for room, suffixes in KEPT.items()
             for each in _walk(root / room) if _is_kept(each, suffixes))  # fmt: skip
    return [path for path in found if path in unknown and _is_public(path, set(), ())]


def _unknown_to_git(root: Path) -> set[str]:
    """Return the files of a checkout that nobody has added; none where it is no checkout."""
    command = ["git", "-C", str(root), "ls-files", "-z", "--others", "--", *KEPT]
    if not (root / ".git").exists() or shutil.which("git") is None:
        return set()
    done = subprocess.run(command, capture_output=True, check=False)
    return set(done.stdout.decode("utf-8", "surrogateescape").split("\0"))


def questions(quiz: str) -> str:
    """Return the quiz without its rubric: headings and questions (in italics)."""
    kept = []
    for paragraph in quiz.split("\n\n"):
        text = paragraph.strip()
        if text.startswith(("#", "*")):
            kept.append(text)
    return "\n\n".join(kept) + "\n"


# --- what goes in --------------------------------------------------------------------------


def _walk(folder: Path) -> Iterator[Path]:
    """Yield the regular files below a folder, sorted; no links, caches or hidden and made files."""
    for path in sorted(folder.iterdir()) if folder.is_dir() else ():
        if path.name.startswith((".", "__pycache__")) or path.is_symlink():
            continue
        if path.is_dir():
            if path.name not in MADE and path.suffix != ".egg-info":
                yield from _walk(path)
        elif path.is_file():
            yield path


def _is_kept(file: Path, suffixes: Collection[str]) -> bool:
    return file.suffix in suffixes or (not file.suffix and file.parent.name == MARKER)


def _is_public(path: str, left_out: set[str], rooms: Collection[str] = ()) -> bool:
    parts = PurePosixPath(path).parts
    names = {*parts, PurePosixPath(path).stem}
    if not left_out.isdisjoint(names):
        return False
    if any(PurePosixPath(path).is_relative_to(each) for each in {*INSTRUCTORS} - {*rooms}):
        return False
    return not any(PRIVATE.search(part) for part in parts)


def _pyproject(text: str) -> str:
    """Return the students' pyproject.toml: without the settings of development tools.

    The course's own build of a wheel stays behind, too: setuptools installs the folder as it is.
    """
    kept = re.split(r"(?m)^(?=\[)", text)
    ours = (
        "[tool.importlinter", "[[tool.importlinter", "[tool.mypy", "[[tool.mypy", "[tool.pytest",
        "[tool.ruff",
    )  # fmt: skip
    text = "".join(part for part in kept if not part.startswith(ours))
    return re.sub(r"(?m)^build-backend = .*\nbackend-path = .*$", BACKEND, text)


def _readme(left_out: Collection[str], *, plain: bool) -> str:
    released = [exercise for exercise in all_exercises() if exercise.slug not in left_out]
    rows = [
        f"| {exercise.number} | [{exercise.slug}](exercises/{exercise.slug}/README.md) "
        f"| {exercise.summary} |"
        for exercise in released
    ]
    return README.format(
        number=released[0].number, slug=released[0].slug, rows="\n".join(rows),
        lesson=PLAIN if plain else WITH_SITE, cloud=NO_CLOUD if plain else CLOUD,
    )  # fmt: skip


# --- files ---------------------------------------------------------------------------------


def _check_free(folder: Path, packed: Path | None) -> None:
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(f"{folder}: expected a new or empty folder; choose another")
    if packed is not None and packed.exists():
        raise InputError(f"{packed}: already exists; remove it or choose another folder")


def pack(target: Path, files: Iterable[tuple[str, bytes, int]], mode: int = 0o644) -> None:
    """Write an archive of files, each its path, content and mode; it has itself this mode."""
    part = target.with_name(target.name + ".part")
    with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data, its_mode in files:
            entry = zipfile.ZipInfo(path, STAMP)
            entry.external_attr = its_mode << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, data)
    part.chmod(mode)
    part.replace(target)


def _and_more(n: int) -> str:
    return f" (and {n} more)" if n > 0 else ""
