"""Make the students' skeletons from the reference solutions, and keep the two in step.

A solution marks what students write, and what they get instead::

    ### BEGIN SOLUTION
    return min(usable, default=None)
    ### SKELETON
    # # TODO(task 2): return the smallest usable distance.
    # return None
    ### END SOLUTION

Everything from BEGIN to END is removed, except the comment lines below SKELETON, which each lose
their first ``# ``. Without a SKELETON part a block becomes one ``# TODO``, and the code around it
must work without it. ``python -m grader.course.skeletons`` writes the skeletons, ``--check`` only
compares.
"""

import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

from grader.course.generated import ROOT, write_or_check
from grader.errors import InputError

_MARKER = re.compile(r"^\s*### (BEGIN SOLUTION|SKELETON|END SOLUTION)\s*$")
_MISSPELT = re.compile(r"^\s*#+\s*(BEGIN[ _]SOLUTION|SKELETON|END[ _]SOLUTION)\b", re.IGNORECASE)
_COMMENT = re.compile(r"^(\s*)# ?(.*)$")


def strip_solution(source: str, where: str = "solution") -> str:
    """Return the skeleton of a solution's source text.

    Raises InputError: a marker is unpaired, misspelt or nested; a line below ``### SKELETON`` is
    not a comment; or there is no block.

    Parameters
    ----------
    source
        Python source with ``### BEGIN SOLUTION`` … ``### END SOLUTION`` blocks.
    where
        Name of the file, for error messages.
    """
    kept: list[str] = []
    begin = 0  # line number where the open block begins; 0: outside of blocks
    skeleton: list[str] | None = None  # lines of the SKELETON part; None: not reached
    blocks = 0
    for number, line in enumerate(source.splitlines(), start=1):
        place = f"{where}, line {number}"
        match _marker(line, place):
            case "BEGIN SOLUTION":
                if begin:
                    raise InputError(
                        f"{place}: BEGIN SOLUTION inside the block that began on line {begin}; "
                        "close that one with ### END SOLUTION first"
                    )
                begin, skeleton = number, None
            case "SKELETON":
                if not begin or skeleton is not None:
                    raise InputError(
                        f"{place}: SKELETON belongs once between ### BEGIN SOLUTION "
                        "and ### END SOLUTION"
                    )
                skeleton = []
            case "END SOLUTION":
                if not begin:
                    raise InputError(f"{place}: END SOLUTION without a BEGIN SOLUTION above it")
                indent = line[: len(line) - len(line.lstrip())]
                kept += [f"{indent}# TODO: your code"] if skeleton is None else skeleton
                begin, blocks = 0, blocks + 1
            case _ if not begin:
                kept.append(line)
            case _ if skeleton is not None:
                skeleton.append(_uncomment(line, place))
    if begin:
        raise InputError(f"{where}, line {begin}: BEGIN SOLUTION is never closed")
    if not blocks:
        raise InputError(f"{where}: no ### BEGIN SOLUTION block, so a student has nothing to write")
    return "\n".join(kept) + "\n"


def _marker(line: str, place: str) -> str | None:
    """Return which marker a line is; None for any other line."""
    if found := _MARKER.match(line):
        return found[1]
    if _MISSPELT.match(line):
        raise InputError(
            f"{place}: {line.strip()!r} looks like a marker; write ### BEGIN SOLUTION, "
            "### SKELETON or ### END SOLUTION"
        )
    return None


def _uncomment(line: str, place: str) -> str:
    """Return a line of a SKELETON part without its leading ``# ``."""
    if not line.strip():
        return ""
    if found := _COMMENT.match(line):
        return (found[1] + found[2]).rstrip()
    raise InputError(
        f"{place}: expected a comment below ### SKELETON, such as '# return None'; "
        f"found {line.strip()!r}"
    )


def skeletons(root: Path = ROOT) -> Iterator[tuple[Path, str]]:
    """Yield (path, text) of every skeleton: the files that the exercise.toml files list."""
    for description in sorted((root / "exercises").glob("*/exercise.toml")):
        exercise = description.parent.name
        for name in tomllib.loads(description.read_text(encoding="utf-8"))["files"]:
            solution = root / "solutions" / exercise / name
            where = solution.relative_to(root).as_posix()
            if not solution.is_file():
                raise InputError(
                    f"{description.relative_to(root).as_posix()}, key files: {name!r} has no "
                    f"solution; expected {where}"
                )
            text = strip_solution(solution.read_text(encoding="utf-8"), where)
            yield description.parent / name, text


def main(arguments: list[str]) -> int:
    """Write exercises/*/FILE from solutions/*/FILE, or with `--check` compare them."""
    command = "python -m grader.course.skeletons"
    return write_or_check(skeletons(), command, arguments)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
