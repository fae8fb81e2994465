"""What a person gives, as it comes: a notebook, an archive, a second copy's name."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TypeVar

from grader.course.beside import beside
from grader.course.submission import is_package
from grader.errors import InputError
from rclpy_virtual_time import fresh_folder

NOTEBOOK = ".ipynb"
ARCHIVES = (".zip", ".tar", ".tar.gz", ".tgz")
FOLDED = 3  # folders in one another, each alone in the one above it, down to the files

T = TypeVar("T")


@contextlib.contextmanager
def as_files(path: Path, names: Sequence[str]) -> Iterator[Path]:
    """Yield what `find_submission` takes: `path`, or a file or folder that was made of it.

    Of a notebook it is what its `%%node` cells write, with what lies beside it; of an archive the
    folder in it; of "agent (1).py", where agent.py is wanted, a file of that name.

    Raises InputError: it can't be read, or there is no node in it.

    Parameters
    ----------
    path
        What was given.
    names
        The files that are wanted, the node's first. Of those that are there the first is yielded.
    """
    with contextlib.ExitStack() as stack:
        given = path
        if path.name.lower().endswith(ARCHIVES) and path.is_file():
            from grader.lms.unpack import unpack  # noqa: PLC0415

            room = stack.enter_context(fresh_folder())
            _read(path, lambda: unpack(path, room))
            given = _folder_in(room)
        staged = stack.enter_context(fresh_folder())
        if given.is_dir():
            given = _of_folder(given, names, staged, path)
        else:
            given = _of_copies(given.parent, names, staged, given) or given
        file = given / names[0] if given.is_dir() else given
        yield _of_notebook(file, names, stack.enter_context(fresh_folder()), path) or given


def one_of(number: Sequence[str], exercise: str | None) -> str | None:
    """Return the exercise that was named, if one was: before the file, or by its option.

    Raises InputError: more than one was.
    """
    named = [*number, *([] if exercise is None else [exercise])]
    if len(named) > 1:
        raise InputError(f"expected one exercise, got {', '.join(named)}")
    return named[0] if named else None


def wanted_in(scenario: str) -> list[str]:
    """Return the files of all exercises, those of the scenario's own exercise first."""
    from grader.course.exercises import all_exercises  # noqa: PLC0415
    from sim.scenario_files import scenario_names  # noqa: PLC0415

    place = scenario_names().get(scenario)
    every = all_exercises()
    own = [each for each in every if place is not None and each.slug in place.parts]
    return list(dict.fromkeys(name for each in (*own, *every) for name in each.files))


def _of_folder(folder: Path, names: Sequence[str], staged: Path, path: Path) -> Path:
    """Return the node's file in a folder, or the folder, if that is for `find_submission`."""
    if is_package(folder):
        return folder
    if found := _of_copies(folder, names, staged):
        return found
    notebooks = [each for each in sorted(folder.glob(f"*{NOTEBOOK}")) if not each.is_symlink()]
    if len(notebooks) == 1 and not any(folder.glob("*.py")):
        return notebooks[0]
    found = next((folder / name for name in names if (folder / name).exists()), None)
    return found if found is not None and folder != path else folder


def _of_notebook(notebook: Path, names: Sequence[str], staged: Path, path: Path) -> Path | None:
    """Write what a notebook's cells define, and what lies beside it; return the node's file.

    None for what is no notebook; one may be saved as a program.
    """
    from grader.nbgrader.exported import may_be_notebook  # noqa: PLC0415

    if not notebook.is_file() or not may_be_notebook(notebook):
        return None
    from grader.nbgrader.cells import last_definitions, modules  # noqa: PLC0415
    from grader.nbgrader.intake import read_cells  # noqa: PLC0415

    cells = [(cell.kind, cell.source) for cell in _read(path, lambda: read_cells(notebook))]
    if not cells:
        return None
    made = modules(cells)
    texts, _ = last_definitions(cells, made)
    own = [name for name in made if name not in wanted_in("")]  # a name of the student's choice
    node = next((name for name in names if name in texts), own[0] if len(own) == 1 else None)
    if node is None:
        there = f"its cells write {', '.join(made[:5])}" if made else "it has no such cell"
        raise InputError(f"{path}: expected a cell that begins with `%%node {names[0]}`; {there}")
    _copy(notebook.parent, staged)
    for name, text in texts.items():
        (staged / name).parent.mkdir(parents=True, exist_ok=True)
        (staged / name).write_text(text, "utf-8")
    return staged / node


def _of_copies(
    folder: Path, names: Sequence[str], staged: Path, given: Path | None = None
) -> Path | None:
    """Return the node's file under its own name, where one that is wanted is there as a copy only.

    Of several copies the last one counts; but a file that was `given` counts before all others.
    """
    from grader.lms.names import copy_number, plain  # noqa: PLC0415

    if given is not None and given.is_symlink():
        return None
    wanted = {plain(name): name for name in names}
    there = [each for each in folder.glob("*.py") if each.is_file() and not each.is_symlink()]
    chosen: dict[str, Path] = {}
    for each in sorted(there, key=lambda each: (each == given, copy_number(each.name))):
        name = wanted.get(plain(each.name), each.name)
        if name != each.name and (each == given or not (folder / name).exists()):
            chosen[name] = each
    if not chosen or (given is not None and plain(given.name) not in wanted):
        return None
    _copy(folder, staged)
    for name, file in chosen.items():
        (staged / file.name).unlink(missing_ok=True)
        shutil.copyfile(file, staged / name)
    if given is not None:
        return staged / wanted[plain(given.name)]
    return next(staged / name for name in names if (staged / name).exists())


def _copy(folder: Path, target: Path) -> None:
    """Copy what comes along with a node of a folder."""
    for name, file in beside(folder.resolve()).files.items():
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, target / name)


def _folder_in(room: Path) -> Path:
    """Return the folder, or the notebook or file, that is all of an unpacked archive."""
    for _ in range(FOLDED):
        inside = [each for each in room.iterdir() if not each.name.startswith((".", "__MACOSX"))]
        if len(inside) != 1 or not inside[0].is_dir() or is_package(room):
            break
        room = inside[0]
    return room


def _read(path: Path, read: Callable[[], T]) -> T:
    try:
        return read()
    except Exception as error:  # whatever a broken file makes its reader raise
        raise InputError(f"{path}: cannot be read ({error or type(error).__name__})") from None
