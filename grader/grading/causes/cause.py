"""What a cause is, and the hint that goes with it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple, Protocol

import msgspec

from grader.course.exercises import Exercise
from grader.recording import Recording

HINTS = "hints.md"
MAX_SAID = 200  # [characters]
MAX_HINTS = 64 * 1024  # [characters]
_HINT = re.compile(r"<details><summary>(?P<title>[^<]*)</summary>(?P<text>.*?)</details>", re.S)
_SOFT_BREAK = re.compile(r"(?<=[^\n|])\n(?!\s|[|>#]|[-*] |\d+\. |$)")
_HEADING = re.compile(r"(?m)^## (?P<title>.+)$")


class Failed(Protocol):
    """A check that failed; `grader.grading.plugin.CheckResult` is one."""

    @property
    def id(self) -> str: ...
    @property
    def kind(self) -> str: ...
    @property
    def message(self) -> str: ...
    @property
    def expected(self) -> str: ...
    @property
    def actual(self) -> str: ...
    @property
    def task(self) -> int: ...
    @property
    def help(self) -> str: ...
    @property
    def where(self) -> str: ...
    @property
    def time(self) -> float | None: ...
    @property
    def scenario(self) -> str | None: ...
    @property
    def hint(self) -> str: ...


ByName = Mapping[str, Recording]


class Hint(msgspec.Struct, frozen=True):
    """A hint of the exercise."""

    title: str  # "Task 2: perceive, hint 1: which beam is ahead?"
    anchor: str  # "hints.md#task-3-perceive"
    text: str  # Markdown


class Cause(msgspec.Struct, frozen=True):
    """The mistake that recordings show, and a hint on the code."""

    text: str
    kind: str  # core or field, of the checks that it explains
    where: str = ""  # the student's line, where it can be told
    hint: Hint | None = None
    explains: tuple[str, ...] = ()  # ids of checks whose own help would lead elsewhere
    check: str = ""  # id of the one in which it was seen

    @classmethod
    def of(
        cls,
        exercise: Exercise,
        text: str,
        failed: Sequence[Failed],
        *,
        where: str = "",
        hint: Hint | None = None,
        replaces_help: bool = False,
        own_hint: bool = True,
    ) -> Cause:
        """Return the cause of some failed checks; `replaces_help`: hide the checks' own help.

        `own_hint`: without a hint, take the hint of the first failed check.
        """
        return cls(
            f"{text[0].upper()}{text[1:]}"
            if text.split(" ", maxsplit=1)[0].rstrip(",:").isalpha()
            else text,
            failed[0].kind,
            where,
            hint or (hint_for(exercise, failed) if own_hint else None),
            tuple(check.id for check in failed) if replaces_help else (),
            failed[0].id,
        )


class Place(NamedTuple):
    """Where a hint stands in hints.md."""

    task: int  # the first number in its heading; 0: it has none
    number: int  # from 1


# exception, what it says, what the hint about it says
EXCEPTIONS = (
    ("TypeError", r"'NoneType' and|and 'NoneType'", "None"),
    ("ValueError", r"min\(\)|max\(\)|empty|zero-size", "min("),
    ("TypeError", r"not JSON serializable", "json.dumps"),
    ("ZeroDivisionError", "", ""),
    ("FileNotFoundError", "", ""),
)


def shortened(said: str) -> str:
    """Return what an exception says, on one line and without what a library adds at length."""
    line = " ".join(said.split())
    return line if len(line) <= MAX_SAID else f"{line[:MAX_SAID]} …"


def sentences(*texts: str) -> str:
    """Return texts behind each other, each with its stop."""
    said = [text if text[-1] in ".?!…" else f"{text}." for text in texts if text]
    return " ".join(said)


def hint_at(exercise: Exercise, place: Place | None) -> Hint | None:
    """Return a hint of the exercise's own page; None if there is none there."""
    return next((hint for at, hint in _hints(exercise) if at == place), None)


def hint_on(exercise: Exercise, said: str) -> Hint | None:
    """Return the hint that names an exception, by Python's own words about it."""
    for name, text, word in EXCEPTIONS:
        if said.startswith(name) and re.search(text, said):
            for _, hint in _hints(exercise):
                about = f"{hint.title} {hint.text}"
                if name in about and word in about:
                    return hint
    return None


def _hints(exercise: Exercise) -> Iterator[tuple[Place, Hint]]:
    path = exercise.folder / HINTS
    parts = _HEADING.split(path.read_text("utf-8")[:MAX_HINTS]) if path.is_file() else [""]
    for title, body in zip(parts[1::2], parts[2::2], strict=True):
        number = re.search(r"\d+", title)
        for i, found in enumerate(_HINT.finditer(body), start=1):
            said = f"{title}. {found['title'].strip()}"
            hint = Hint(said, anchor(title), _flowing(found["text"].strip()))
            yield Place(int(number[0] if number else 0), i), hint


def _flowing(markdown: str) -> str:
    """Return a text with a line for each paragraph; code, lists and tables keep theirs."""
    parts = markdown.split("```")
    return "```".join(part if i % 2 else _SOFT_BREAK.sub(" ", part) for i, part in enumerate(parts))


def hint_for(exercise: Exercise, failed: Sequence[Failed]) -> Hint | None:
    """Return the hint for the first of the failed checks that has one."""
    found = next((check.hint for check in failed if check.hint), "")
    return hint_at(exercise, place_of(found)) if found else None


def place_of(text: str) -> Place:
    """Return the place that "3.1" names: task and number."""
    return Place(*map(int, text.split(".")))


def anchor(heading: str) -> str:
    """Return the address of a heading, as GitHub and the site make it."""
    words = re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")
    return f"{HINTS}#{words}"
