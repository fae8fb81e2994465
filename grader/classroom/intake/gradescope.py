"""Gradescope's "Export Submissions": folders `submission_ID`, and a file that says whose they are.

`submission_metadata.yml` has, for each folder, `:submitters:` with `:name:`, `:sid:` and `:email:`,
and `:created_at:`. A group's submission counts for each of its members.

Source: the export itself; public readers of it agree on these keys (search for `:submitters:`).
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

import yaml

from grader.classroom.intake.entries import Entry, Read, SetAside, Who
from grader.course.submission import read_regular_file
from grader.errors import InputError

METADATA = "submission_metadata.yml"
MAX_METADATA = 64 * 1024 * 1024  # [bytes]: it holds the results of every submission
FOLDER = re.compile(r"submission_(?P<id>\d+)")


def read(folder: Path, paths: Sequence[Path]) -> Read:
    """Return the submissions that the metadata name."""
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
        people = list(_submitters(about)) if isinstance(about, Mapping) else []
        if not people:
            reason = f"{METADATA} does not say whose it is"
            found.set_aside.append(SetAside(path.name, reason))
        time = about.get(":created_at") if isinstance(about, Mapping) else None
        text = time.isoformat() if isinstance(time, datetime) else ""
        found.entries.extend(Entry(path, who, time=text) for who in people)
    missing = sorted(set(map(str, known)) - {path.name for path in paths})
    found.set_aside.extend(
        SetAside(name, f"in {METADATA}, but there is no such folder") for name in missing
    )
    return found


def _metadata(file: Path) -> Mapping[Any, Any]:
    try:
        text = read_regular_file(file, MAX_METADATA).decode("utf-8")
        loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
        known = yaml.load(text, loader)
    except (OSError, ValueError, yaml.YAMLError, RecursionError) as error:
        raise InputError(
            f"{file}: expected Gradescope's metadata ({type(error).__name__}); "
            "export the submissions again"
        ) from None
    if not isinstance(known, Mapping):
        raise InputError(f"{file}: expected Gradescope's metadata, a folder's name to a line each")
    return known


def _submitters(about: Mapping[Any, Any]) -> Iterator[Who]:
    people = about.get(":submitters")
    for person in people if isinstance(people, list) else []:
        if isinstance(person, Mapping):
            name, sid, email = (str(person.get(key) or "") for key in (":name", ":sid", ":email"))
            if name or sid or email:
                yield Who(name or email or sid, "gradescope", sid, email)
