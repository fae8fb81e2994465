"""Files that a program of the course generates: write them, or say which are out of step."""

import re
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from grader.errors import GraderError, InputError

ROOT = Path(__file__).resolve().parents[2]
CHECK = "--check"
TEXTS = {".md", ".py", ".toml"}


def write_or_check(
    files: Iterable[tuple[Path, str]], command: str, arguments: Sequence[str] = ()
) -> int:
    """Write the files whose text differs from what is on disk; return an exit code.

    Parameters
    ----------
    files
        Path and text of each.
    command
        The command line that writes them.
    arguments
        Those of the command line; `--check` writes nothing and names the files out of step.

    Returns
    -------
    int
        0: all files are in step now. 1: some are not. 2: wrong usage.
    """
    if list(arguments) not in ([], [CHECK]):
        print(f"expected no argument or {CHECK}, as in `{command} {CHECK}`", file=sys.stderr)
        return 2
    stale = 0
    try:
        for path, text in files:
            if path.is_file() and path.read_text("utf-8") == text:
                continue
            stale += 1
            name = path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else path.name
            if arguments:
                print(f"{name} is out of step: run `{command}`")
                continue
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, "utf-8")
            print(f"wrote {name}")
    except (InputError, GraderError) as error:
        print(error, file=sys.stderr)
        return 2
    return 1 if arguments and stale else 0


def still_in(word: str, exercise: str) -> str:
    """Return which files of an exercise still have a word that is no longer right, in words."""
    places = ("exercises/{}/*", "grader/exercises/{}/**/*", "solutions/{}/**/*",
              "lessons/exercises/{}/*", "notebooks/text/*/*.md")  # fmt: skip
    files = {path for place in places for path in ROOT.glob(place.format(exercise))}
    named = re.compile(rf"\b{re.escape(word)}\b")
    found = [
        path.relative_to(ROOT).as_posix()
        for path in sorted(files)
        if path.suffix in TEXTS and named.search(path.read_text("utf-8"))
    ]
    return f"; {word!r} is still in {', '.join(found)}" if found else ""
