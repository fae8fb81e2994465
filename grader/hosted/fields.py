"""Fields of what judge and host say to each other for the course, and how long they may be."""

from __future__ import annotations

from typing import Annotated

import msgspec

MAX_NAME = 256  # [characters]
MAX_TEXT = 20_000  # [characters]
MAX_LINE = MAX_TEXT // 10  # [characters]

Name = Annotated[str, msgspec.Meta(max_length=MAX_NAME)]
Text = Annotated[str, msgspec.Meta(max_length=MAX_TEXT)]
Nanoseconds = Annotated[int, msgspec.Meta(ge=0, le=2**62)]


def sendable(text: str) -> str:
    """Replace what UTF-8 can't carry: half characters, such as those in undecodable file names."""
    return text.encode("utf-8", "replace").decode()
