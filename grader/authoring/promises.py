"""What an exercise's README says that a node does, sentence by sentence, and who checks it.

`solutions/EXERCISE/promises.toml` has three tables, whose keys are the README's own words::

    [checked]
    "Publish exactly one `Twist` for each scan." = ["one_command_per_scan"]

    [not_graded]  # the README says so, too
    "The skeleton logs a line at start-up." = "Log lines are for whoever reads them."

    [explains]    # says nothing that a node has to do
    sentences = ["Straight ahead is angle 0, left is positive."]

So a sentence that is changed has to be looked at again, and a check cannot go without its promise.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import msgspec

from grader.course.exercises import Exercise
from sim.toml_input import convert, parse_toml, read_toml

PROMISES = "promises.toml"
BEGIN, END = re.compile(r"^## (Topics|Tasks)"), re.compile(r"^## (?!Topics|Tasks)")
RULE = re.compile(r"^\|[\s|:-]+\|$")  # of a table
ITEM = re.compile(r"^(\d+\.|-)\s+")
SENTENCE = re.compile(r"(?<=[.!?])\s+(?=[A-Z*`0(])")
Checks = Annotated[tuple[str, ...], msgspec.Meta(min_length=1)]


class _Explains(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    sentences: tuple[str, ...] = ()


class Promises(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The list of one exercise."""

    checked: dict[str, Checks]
    not_graded: dict[str, Annotated[str, msgspec.Meta(min_length=10)]] = {}
    explains: _Explains = _Explains()

    @property
    def sentences(self) -> list[str]:
        """All sentences of the list."""
        return [*self.checked, *self.not_graded, *self.explains.sentences]


def promises(exercise: Exercise) -> Promises:
    """Return the list of an exercise.

    Raises
    ------
    InputError
        The file is missing or broken.
    """
    path = exercise.solutions / PROMISES
    return convert(parse_toml(read_toml(path), str(path)), Promises, str(path))


def sentences(readme: Path) -> list[str]:
    """Return the sentences and the rows of tables in the sections on topics and tasks."""
    return [text for block in _blocks(readme.read_text("utf-8")) for text in _split(block)]


def _blocks(text: str) -> Iterator[str]:
    """Return the paragraphs, list items and rows of these sections, each on one line."""
    inside, fence, header = False, False, False
    block: list[str] = []
    for line in [*text.splitlines(), ""]:
        words = line.strip()
        if words.startswith("```"):
            fence, words = not fence, ""
        if not fence and words.startswith("## "):
            inside = bool(BEGIN.match(words)) or (inside and not END.match(words))
            words = ""
        row = words.startswith("|")
        starts = not words or row or ITEM.match(words) is not None
        if starts and block:
            yield " ".join(block)
            block = []
        if not row:
            header = True  # the next row is the head of a table
        if not inside or fence or not words or line.startswith("    course "):
            continue
        if row:
            if not header and not RULE.match(words):
                yield words
            header = False
        else:
            block.append(ITEM.sub("", words))


def _split(block: str) -> list[str]:
    return [block] if block.startswith("|") else SENTENCE.split(block)
