"""The files that this kernel's `%%node` cells wrote."""

import ast
from dataclasses import dataclass, field
from pathlib import Path

from grader.course.exercises import Exercise, all_exercises
from grader.errors import InputError


@dataclass
class Session:
    """The files of this kernel's `%%node` cells."""

    written: dict[str, Path] = field(default_factory=dict)  # by name, the latest last
    refused: dict[str, str] = field(default_factory=dict)  # by name: why its last cell wasn't saved

    def wrote(self, path: Path) -> None:
        """Remember a file that was written."""
        self.refused.pop(path.name, None)
        self.written.pop(path.name, None)
        self.written[path.name] = path

    def file_for(self, exercise: Exercise, file: str | Path | None) -> Path:
        """Return the file to judge for an exercise.

        Raises InputError: it is not there, or its last cell was not saved.
        """
        if file is None:
            file = self.written.get(exercise.files[0], Path(exercise.files[0]))
        names = dict.fromkeys((Path(file).name, *exercise.files))
        return self.usable(Path(file), list(names))

    def file_to_drive(self, file: str | Path | None) -> Path:
        """Return the node to drive: the given one, or that of the last cell's exercise.

        Raises InputError: there is none, or its last cell was not saved.
        """
        if file is not None:
            return self.usable(Path(file), [Path(file).name])
        last = self._last()
        exercise = exercise_of(last.name)
        node = last if exercise is None else last.with_name(exercise.files[0])
        chosen = node if node.is_file() else last
        return self.usable(chosen, [chosen.name, last.name])

    def last_exercise(self) -> Exercise:
        """Return the exercise that the last cell's file belongs to.

        Raises InputError: no cell has written a file, or it belongs to no exercise.
        """
        last = self._last().name
        exercise = exercise_of(last)
        if exercise is None:
            raise InputError(
                f"{last} is no exercise's file; say which exercise it is for, "
                f'as in check("1", file="{last}")'
            )
        return exercise

    def usable(self, path: Path, names: list[str]) -> Path:
        """Return a file's absolute path.

        Raises InputError: it is not there, or the last cell of one of these names was not saved, or
        of a module that it imports.
        """
        for name in [*names, *(f"{module}.py" for module in _imports_of(path))]:
            if name in self.refused:
                raise InputError(
                    f"the last %%node {name} cell was not saved ({self.refused[name]}); "
                    "correct it and run it again"
                )
        if not path.exists():
            raise InputError(
                f"there is no {path} here: run the cell that starts with “%%node {path.name}” first"
            )
        return path.resolve()

    def _last(self) -> Path:
        """Return the last cell's file that no other cell's imports.

        After a kernel's restart, it is the newest node that is here.

        Raises InputError: there is none.
        """
        if self.written:
            latest = list(reversed(self.written.values()))
            modules = set().union(*map(_imports_of, latest))
            return next((path for path in latest if path.stem not in modules), latest[0])
        every = (Path(exercise.files[0]) for exercise in all_exercises())
        here = [node for node in every if node.is_file() and node.name not in self.refused]
        if not here or self.refused:
            raise self._nothing_written()
        return max(here, key=lambda node: node.stat().st_mtime).resolve()

    def _nothing_written(self) -> InputError:
        if self.refused:
            name, why = next(reversed(self.refused.items()))
            return InputError(
                f"the %%node {name} cell was not saved ({why}); correct it and run it again"
            )
        return InputError(
            "no %%node cell has run in this kernel yet: run the one with your node first, "
            "or name the file with file="
        )


def imported(tree: ast.Module) -> set[str]:
    """Return the modules that a program imports, by the first part of their names."""
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add(node.module or "")
    return {name.partition(".")[0] for name in names}


def _imports_of(path: Path) -> set[str]:
    try:
        return imported(ast.parse(path.read_bytes()))
    except (OSError, SyntaxError, ValueError):  # whoever runs it says so
        return set()


def exercise_of(name: str) -> Exercise | None:
    """Return the exercise that has a file of this name."""
    found = (exercise for exercise in all_exercises() if name in exercise.files)
    return next(found, None)


SESSION = Session()
