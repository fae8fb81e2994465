"""Gradescope: folders `submission_ID` with a list of whose they are, and `results.json`.

- "Export Submissions" has a file `submission_metadata.yml` with, for each folder, `:submitters:`
  with `:name:`, `:sid:` and `:email:`, and `:created_at:`. A group's submission counts for each of
  its members. Source: the export itself; public readers of it agree on these keys.
- `results.json` is what an autograder leaves there (`grader.classroom.autograder`). Source:
  Gradescope, "Autograder Specifications", "Output Format".
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import yaml

from grader.errors import InputError
from grader.lms.book import Mark, Task
from grader.lms.clean import one_line, visible
from grader.lms.people import EMAIL, Match, Roster, each_once, folded
from grader.lms.platform import Entry, Platform, Read, SetAside, Who, by_key, by_name
from grader.lms.told import LONGEST, microseconds
from grader.lms.unpack import OF_CLASS
from grader.report.facts import UNJUDGED
from rclpy_virtual_time import FileReader

METADATA = "submission_metadata.yml"
MAX_METADATA = 64 * 1024 * 1024  # [bytes]: it holds the results of every submission
FOLDER = re.compile(r"submission_(?P<id>\d+)")

MAX_OUTPUT = 4000  # [characters] of one test
SEEN = {"output_format": "text", "visibility": "visible"}
WORDS = {
    "pass": "Passed.",
    "skip": "Not judged: a check that it needs did not pass.",
    "unavailable": "Not counted: a library is not installed where the judge runs.",
}


# --- what it hands over --------------------------------------------------------------------------


def read(folder: Path, paths: Sequence[Path]) -> Read:
    if not any(path.name == METADATA for path in paths):
        return Read(left=list(paths))
    known = _metadata(folder / METADATA)
    found = Read()
    for path in paths:
        if path.name == METADATA:
            continue
        if not FOLDER.fullmatch(path.name) or path.is_symlink() or not path.is_dir():
            found.left.append(path)
            continue
        about = known.get(path.name)
        if about is None or not about.people:
            reason = f"{METADATA} does not say whose it is"
            found.set_aside.append(SetAside(path.name, reason))
            continue
        version = microseconds(about.time)
        people = (Who(name or email or sid, PLATFORM, sid, email)
                  for name, sid, email in about.people)  # fmt: skip
        found.entries.extend(Entry(path, who, version=version, time=about.time) for who in people)
    for name in sorted(set(known) - {path.name for path in paths}):
        whose = ", ".join(one_line(next(filter(None, each)), 60) for each in known[name].people)
        reason = f"in {METADATA}, but there is no such folder; it is of {whose or 'nobody'}"
        found.set_aside.append(SetAside(name, reason))
    return found


@dataclass(frozen=True)
class _Submission:
    """What the metadata say of a folder."""

    people: list[tuple[str, str, str]]  # name, sid, email of each who hands it in
    time: str


def _metadata(file: Path) -> dict[str, _Submission]:
    try:
        return OF_CLASS.read(submissions_in, file=file, returns=dict[str, _Submission])
    except (OSError, FileReader.Refused) as error:
        raise InputError(
            f"{file}: expected Gradescope's metadata ({error}); export the submissions again"
        ) from None


def submissions_in(file: IO[bytes]) -> dict[str, _Submission]:
    """Return what the metadata say of each folder.

    Raises FileReader.Refused: they are no metadata.
    """
    loader = getattr(yaml, "CBaseLoader", yaml.BaseLoader)  # 0012 is a number of a student's
    known = yaml.load(file.read(MAX_METADATA).decode("utf-8"), loader)
    if not isinstance(known, Mapping):
        raise FileReader.Refused("a folder's name to a line each")
    return {str(name): _submission(about) for name, about in known.items()}


def _submission(about: object) -> _Submission:
    if not isinstance(about, Mapping):
        return _Submission([], "")
    people, time = about.get(":submitters"), about.get(":created_at")
    each = [
        (_text(one.get(":name")), _text(one.get(":sid")), _text(one.get(":email")))
        for one in (people if isinstance(people, list) else [])
        if isinstance(one, Mapping)
    ]
    moment = re.sub(r"\s+(?=(?:Z|[+-]\d\d:?\d\d)$)", "", _text(time))
    return _Submission([one for one in each if any(one)], moment[: LONGEST + 1])


def _text(value: object) -> str:
    """Return what is a text; a list that holds itself many times is none."""
    return value if isinstance(value, str) else ""


def match(roster: Roster, who: Who, place: str) -> Match:
    """Return whom an address means; students type their numbers themselves."""
    if who.email and EMAIL in roster.kinds:
        return by_key(roster, who, roster.one(EMAIL, who.email))
    found, named = roster.by_word(who.id, who.email), roster.every("name", folded(who.name))
    if found is None:
        return by_name(roster, who)
    if named and found not in named:
        return Match((), each_once((found, *named)))
    return Match((found,), sure=True)


def key_of(entry: Entry) -> str:
    return entry.who.email or entry.who.id or entry.who.name


def sheet(header: Sequence[str]) -> str:
    named = {"name", "full name", "first name", "last name", "student", "student name"}
    return "gradescope" if "sid" in header and named & set(header) else ""


# --- what it takes back --------------------------------------------------------------------------


def results_json(marks: Sequence[Mark], tasks: Sequence[Task]) -> dict[str, Any] | None:
    """Return one student's results; None if any has no points, which would count as zero."""
    by_slug = {mark.exercise: mark for mark in marks}
    mine = [(task, by_slug[task.slug]) for task in tasks if task.slug in by_slug]
    scores = [mark.points for _, mark in mine if mark.points is not None]
    if len(scores) < len(mine):
        return None
    tests: list[dict[str, Any]] = []
    lines: list[str] = []
    several = len(mine) > 1
    for number, (task, mark) in enumerate(mine, start=1):
        prefix, place = (f"{task.title}: ", f"{number}.") if several else ("", "")
        tests += [_test(check, f"{place}{i}", prefix) for i, check in enumerate(mark.checks, 1)]
        lines += [f"{task.title}: {mark.points:g} of {task.points:g} points", *mark.notes]
    seconds = sum(mark.seconds for _, mark in mine)
    return {
        "score": round(sum(scores), 2),
        **({"execution_time": max(1, round(seconds))} if seconds else {}),
        "output": "\n".join(lines),
        "tests": tests,
        **SEEN,
    }


def _test(check: Mapping[str, Any], number: str, prefix: str) -> dict[str, Any]:
    field = check.get("kind") == "field"
    test: dict[str, Any] = {
        "name": prefix + one_line(check.get("title") or check.get("id") or "check", 250),
        "number": number,
        "output": _output(check),
        "tags": ["field" if field else "core"],
        **SEEN,
        "extra_data": {"check": one_line(check.get("id") or ""), "outcome": check.get("outcome")},
    }
    if check.get("outcome") not in UNJUDGED and not check.get("waived"):
        test["status"] = "passed" if check.get("outcome") == "pass" else "failed"
        if not field:
            test["score"] = float(check.get("points") or 0)
            test["max_score"] = float(check.get("max_points") or 0)
    return test


def _output(check: Mapping[str, Any]) -> str:
    lines = [WORDS.get(str(check.get("outcome")), ""), visible(check.get("message") or "")]
    for name, key in (("Expected", "expected"), ("Actual", "actual"), ("Look at next", "help")):
        if check.get(key):
            lines.append(f"{name}: {visible(check[key])}")
    text = "\n".join(line for line in lines if line)
    return text if len(text) <= MAX_OUTPUT else text[: MAX_OUTPUT - 1] + "…"


PLATFORM = Platform(
    "Gradescope", "gradescope", read, sheet, id_kind=EMAIL, folds=True, key_of=key_of, match=match,
    metadata=METADATA,
)  # fmt: skip
