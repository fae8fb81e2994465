"""A notebook saved as a program: find the cells that write files in it. None of it is run.

JupyterLab's *Executable Script* (nbconvert; VS Code's export, too) has a call for each magic;
Colab's *Download .py* has the whole cell as a comment; jupytext's percent format has a mark above
each cell and comments the magic alone; its hydrogen format has it as it was typed. In jupytext's
other formats nobody can tell where a cell ends.
"""

import ast
import re
from collections.abc import Iterator
from contextlib import suppress
from itertools import takewhile
from pathlib import Path

from grader.course.submission import read_regular_file

SUFFIX = ".ipynb"
MAGIC = re.compile(r"(?:# ?)?(%%(?:node|writefile|file)[ \t]+\S.*)")
CALL = re.compile(r"get_ipython\(\)\.run_cell_magic(\(.*\))\s*")
COLAB = "# Commented out IPython magic"
MARK = re.compile(r"# (?:%%(?:[ %].*)?|In ?\[[ \d]*\]:?)\s*")  # where a cell begins
# What runs in a notebook only, and what also may be a comment without a meaning.
ONLY = rb"get_ipython\(\)|from grader\.notebook import \*|(?:# ?)?%load_ext grader\."
SIGN = re.compile(
    rb"^(?:\xef\xbb\xbf)?(?:" + ONLY + rb"|(?:# ?)?%%(?:node|writefile|file)[ \t]|\s*\{\s*\"cells)",
    re.MULTILINE,
)
IS_ONE = re.compile(rb"^(?:" + ONLY + rb")", re.MULTILINE)


def may_be_notebook(path: Path) -> bool:
    """Return whether a file is a notebook, or a program that may be saved from one."""
    try:
        return path.suffix.lower() == SUFFIX or bool(SIGN.search(read_regular_file(path)))
    except OSError:
        return False


def cells_written(program: str) -> list[str] | None:
    """Return the cells that write files, as they were typed; None if it is no notebook."""
    lines = program.removeprefix("\ufeff").replace("\r\n", "\n").split("\n")
    return list(_cells(lines)) or ([] if IS_ONE.search(program.encode("utf-8")) else None)


def _cells(lines: list[str]) -> Iterator[str]:
    number, in_cell = 0, False  # nothing but comments since a mark
    while number < len(lines):
        line, number = lines[number], number + 1
        body: list[str] = []
        if line.startswith(COLAB):
            body = list(takewhile(lambda each: each.startswith("#"), lines[number:]))
            cell = [each[1:].removeprefix(" ") for each in body]
            if any(map(MAGIC.fullmatch, cell)):
                yield "\n".join(cell)
        elif call := CALL.fullmatch(line):
            with suppress(ValueError, SyntaxError, RecursionError, MemoryError):
                magic, words, text = ast.literal_eval(call[1])
                yield f"%%{magic} {words}\n{text}"
        elif in_cell and (found := MAGIC.fullmatch(line)):
            body = list(takewhile(lambda each: not MARK.fullmatch(each), lines[number:]))
            yield "\n".join([found[1], *body])
        in_cell = bool(MARK.fullmatch(line)) or (in_cell and line.startswith("#"))
        number += len(body)
