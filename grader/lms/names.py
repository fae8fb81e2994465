"""Names: of students as safe folders, of files as students vary them."""

import hashlib
import re
import unicodedata
from collections.abc import Container

from grader.course.beside import is_hidden

RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)  # by Windows
MAX_NAME = 80  # [characters] of a student's id
MARK = 6  # [characters] that tell two of one name apart
MARKED = re.compile(rf"~[0-9a-f]{{{MARK},}}$", re.IGNORECASE)
# "agent (1).py", "agent-2.py", "agent - Copy.py"
COPIED = re.compile(r"(?:\s*\((\d+)\)|-(\d+)|\s+-?\s*copy)$", re.IGNORECASE)


def student_id(name: str) -> str:
    """Return a name that looks the same and is safe for a folder: NFC, no separators, no dots.

    It begins with no dash, lest `tar *` among such folders take one for an option.
    """
    text = unicodedata.normalize("NFC", name.encode("utf-8", "replace").decode("utf-8"))
    text = "".join(c if c.isprintable() and c not in '/\\:*?"<>|' else "_" for c in text)
    text = text.strip(" .").lstrip(" .-")[:MAX_NAME].strip(" .")
    while len(text.encode()) > 200:  # a file system counts bytes
        text = text[:-1]
    return f"_{text}" if RESERVED.fullmatch(text) else text or "unnamed"


def marked(name: str, original: str, taken: Container[str], *, always: bool = False) -> str:
    """Return the name, marked if another student has it; the same mark in every run.

    Who hands in a name that looks marked gets a mark, too: nobody can choose another's.
    """
    if not always and not MARKED.search(name) and name.casefold() not in taken:
        return name
    digest = hashlib.sha256(original.encode("utf-8", "surrogateescape")).hexdigest()
    lengths = range(MARK, len(digest) + 1)  # of two entries, the originals differ
    every = (f"{name}~{digest[:length]}" for length in lengths)
    return next(each for each in every if each.casefold() not in taken)


def may_enter(name: str) -> bool:
    """Return whether a file or folder of that name can be a student's work."""
    return not is_hidden(name)


def plain(name: str) -> str:
    """Return a file's name without what browsers and platforms add to a second copy."""
    return _split(unicodedata.normalize("NFC", name).casefold())[0]


def uncopied(name: str) -> str:
    """Return a file's name as it was before a browser or platform marked it as a second copy."""
    bare = _split(name)[0]
    return name if bare.startswith(".") else bare


def copy_number(name: str) -> int:
    """Return the number of a copy: 2 for "agent (2).py"; 0 if there is none, -1 for a "Copy"."""
    return _split(name)[1]


def numbered(name: str) -> tuple[str, int]:
    """Return a user's name and the number that GitHub Classroom adds to another repository."""
    stem, dash, number = name.rpartition("-")
    return (stem, int(number)) if dash and re.fullmatch(r"[0-9]{1,2}", number) else (name, 0)


def _split(name: str) -> tuple[str, int]:
    stem, dot, suffix = name.rpartition(".")
    stem, number = stem.strip(), 0
    while found := COPIED.search(stem):
        digits = found[1] or found[2]
        number = max(number, int(digits[:9])) if digits else number or -1
        stem = stem[: found.start()].strip()
    return stem + dot + suffix, number
