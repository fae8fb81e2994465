"""Compile a student's file as `python3 FILE` does, with the same files refused.

`compile` takes bytes, too, but is milder: outside of strings it lets bytes pass that are not UTF-8,
where Python that reads a file wants a declared encoding (PEP 263). And without `dont_inherit` the
file would have the `__future__` of the module that compiles it: annotations would never run.

Source: CPython 3.11, Parser/tokenizer.c, `tok_underflow_file` and `check_coding_spec`.
"""

from __future__ import annotations

import codecs
import re
from pathlib import Path
from types import CodeType

DECLARED = re.compile(rb"[ \t\f]*#.*?coding[:=][ \t]*[-\w.]+")  # PEP 263
EMPTY = re.compile(rb"[ \t\f]*(?:#|$)")  # or a comment: the declaration may be in the next line
LINE = re.compile(rb"\r\n|\r|\n")
try:
    compile(b"#\xff", "", "exec")
    LOOKS_ON = False
except SyntaxError:  # this Python has gh-63161: a second line may declare what the first is in
    LOOKS_ON = True
ADVICE = "but no encoding declared; see https://peps.python.org/pep-0263/ for details"


def compiled(file: str) -> CodeType:
    """Return the code of a file.

    Raises SyntaxError, ValueError: Python does not accept it.
    """
    source = Path(file).read_bytes()
    _check_encoding(source, file)
    return compile(source, file, "exec", dont_inherit=True)


def _check_encoding(source: bytes, file: str) -> None:
    if source.startswith(codecs.BOM_UTF8):
        return  # whether it is UTF-8, and declares nothing else, is for `compile`
    first, *rest = LINE.split(source, 2)
    if LOOKS_ON and EMPTY.match(first) and rest and DECLARED.match(rest[0]):
        return
    may_declare = True
    for number, line in enumerate(LINE.split(source), start=1):
        if may_declare and DECLARED.match(line):
            return
        may_declare = may_declare and number < 2 and EMPTY.match(line) is not None
        try:
            line.decode()
        except UnicodeDecodeError as error:
            byte = f"\\x{line[error.start]:02x}"
            said = f"Non-UTF-8 code starting with '{byte}' in file {file} on line {number}"
            raise SyntaxError(f"{said}, {ADVICE}") from None
