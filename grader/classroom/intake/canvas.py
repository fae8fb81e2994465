"""Canvas's "Download Submissions": flat files that carry name and ids in front.

Source: instructure/canvas-lms, lib/content_zipper.rb: `get_filename` joins the sortable name in
lower case without anything but word characters, `LATE`, and the user's id (`anon_` and an
anonymous id where names are hidden); `add_upload_submission` adds the attachment's id and the
display name; text entries end in `_text.html`, web addresses in `_link.html`. Group submissions
carry the group's name and one member's id.

A second upload of a file gets `-1` at its end, and a higher attachment id.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from grader.classroom.intake.entries import Entry, Read, SetAside, Who

# From the left: what the student called the file can't reach the ids in front of it. But a name may
# hold what looks like ids, and in some places students choose their own: UNCLEAR says when the file
# might be another's. It has to be a look at Canvas then, for both would lose by a guess.
_WHO = r"(?:(?P<name>\w*?)_)??(?:(?P<late>LATE)_)?(?P<id>\d+|anon_[A-Za-z0-9]+)"
UPLOAD = re.compile(rf"{_WHO}_(?P<attachment>\d+)_(?P<file>.+)", re.DOTALL)
UNCLEAR = re.compile(r"(?:LATE_)?\d{3,}_.+", re.DOTALL)  # what seems to be the file's own name
WHOSE = (
    "its name begins with a number, or its student's name ends with one: whose it is can't be "
    "told; look into Canvas, and rename the file"
)
TYPED = re.compile(rf"{_WHO}_(?P<kind>text|link)\.html")
TYPED_IN = {"text": "text typed into Canvas.html", "link": "web address.html"}


def read(folder: Path, paths: Sequence[Path]) -> Read:
    """Return the uploads among the files, and what was typed into a form."""
    found = Read()
    for path in paths:
        upload, typed = UPLOAD.fullmatch(path.name), TYPED.fullmatch(path.name)
        if path.is_symlink() or not path.is_file():
            found.left.append(path)
        elif upload is not None and UNCLEAR.fullmatch(upload["file"]):
            found.set_aside.append(SetAside(path.name, WHOSE))
        elif upload is not None:
            found.entries.append(
                Entry(
                    path,
                    _who(upload),
                    upload["file"],
                    int(upload["attachment"][:18]),
                    late=upload["late"] is not None,
                )
            )
        elif typed is not None:  # shows what is there if there is no file
            late = typed["late"] is not None
            found.entries.append(Entry(path, _who(typed), TYPED_IN[typed["kind"]], late=late))
        else:
            found.left.append(path)
    return found


def _who(match: re.Match[str]) -> Who:
    name = match["name"] or ""
    anonymous = match["id"].startswith("anon_")
    return Who(name or match["id"], "canvas", match["id"] if not anonymous else "")
