"""The file in a `%%node` cell: its name, and whether Python can parse it. None of it is run."""

import re
import warnings

from grader.nbgrader.cells import QUOTES, Definition

MAGIC = "%%node"
NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_-]{0,95}\.py")


class CellProblem(Exception):
    """A cell is wrong: a sentence for the student, and the line, if there is one."""

    def __init__(self, text: str, *, line: int | None = None, shown: str = "") -> None:
        super().__init__(text)
        self.text = text
        self.line = line  # of the file, 1 is the first
        self.shown = shown  # that line, with carets below it


def file_name(words: str) -> str:
    """Return the file that the words after `%%node` name.

    Raises CellProblem: they are not the plain name of a Python file.
    """
    name = words.strip().strip(QUOTES)
    if NAME.fullmatch(name):
        return name
    got = f"“{name[:80]}”" if name else "nothing"
    if "/" in name or "\\" in name:
        advice = "leave out the folder: the file is written where the notebook is"
    elif not name:
        advice = f"write it on the first line, as in “{MAGIC} my_node.py”"
    elif not name.endswith(".py"):
        advice = f"write “{MAGIC} {_suggested(name)}”, and nothing else, on the first line"
    else:
        advice = f"use letters, digits and _, as in “{MAGIC} {_suggested(name)}”"
    raise CellProblem(f"expected the name of a Python file after {MAGIC}, got {got}: {advice}")


def ended(source: str) -> str:
    """Return a text with a newline at its end."""
    return source if source.endswith("\n") else source + "\n"


def check_syntax(cell: Definition) -> None:
    """Make sure that Python can parse a file.

    Raises CellProblem: it can't; the problem has the line.
    """
    if not cell.text.strip():
        raise CellProblem("the cell is empty below its first line: there is nothing to save")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            compile(cell.text, cell.file, "exec", dont_inherit=True)
    except SyntaxError as error:
        raise _problem_of(error, cell.text) from None
    except UnicodeEncodeError:
        raise CellProblem("the cell has characters that no text file can hold") from None
    except ValueError as error:
        raise CellProblem(f"Python can't read it: {error}") from None
    except (RecursionError, MemoryError):
        raise CellProblem("Python can't read it: too many brackets within brackets") from None


def _problem_of(error: SyntaxError, source: str) -> CellProblem:
    line = error.lineno or 0
    lines = source.split("\n")
    if not 1 <= line <= len(lines):
        return CellProblem(f"{error.msg}; the file ends too early")
    text = lines[line - 1].rstrip("\r")
    column = min(max(1, error.offset or 1), len(text) + 1)
    same_line = error.end_lineno in (None, line)
    width = max(1, (error.end_offset or 0) - column) if same_line else 1
    before = "".join("\t" if letter == "\t" else " " for letter in text[: column - 1])
    carets = "^" * max(1, min(width, len(text) - column + 1))
    words = error.msg
    if text.lstrip().startswith(("%", "!")):
        words += "; notebook commands (% and !) don't belong in a file: put them in another cell"
    return CellProblem(words, line=line, shown=f"{text}\n{before}{carets}")


def _suggested(name: str) -> str:
    first = name.partition(" ")[0].removesuffix(".py")
    stem = "_".join(re.findall(r"[A-Za-z0-9_]+", first))
    return f"{stem if NAME.fullmatch(stem + '.py') else 'my_node'}.py"
