"""Read what a student sends to have a check looked at again: the text of the feedback page.

It comes by mail or as a file, so it may be anything; it is read in a cell (`grader.link.cell`).
"""

from __future__ import annotations

import re

from grader.link.cell import Refused
from grader.lms.clean import visible

MOST = 20_000  # [characters]
LAST = "please look at"
FIELD = re.compile(rf"[>\s]*(student|exercise|check|moment|{LAST})\s*:[ \t]*(.*)", re.IGNORECASE)
QUOTED = re.compile(r"^[>\s]+")
EXPECTED = (
    "expected the text that a feedback page makes, with the lines Student, Exercise, Check, "
    "Moment and Please look at"
)


def fields_of(text: str) -> dict[str, str]:
    """Return what the lines say, by their small names; a mail may quote them, and say more.

    Raises Refused: it is no request.
    """
    found: dict[str, str] = {}
    for line in visible(text[:MOST]).splitlines():
        match = None if LAST in found else FIELD.fullmatch(line)
        if match:
            found.setdefault(match[1].lower(), match[2].strip())
        elif LAST in found:
            found[LAST] += " " + QUOTED.sub("", line)
    found = {name: " ".join(words.split()) for name, words in found.items()}
    if not all(found.get(name) for name in ("student", "exercise", LAST)):
        raise Refused(f"this is no request: {EXPECTED}")
    return found
