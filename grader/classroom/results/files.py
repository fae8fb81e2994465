"""Write a file so that nobody reads half of one."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO


def write_text(path: Path, text: str) -> Path:
    """Replace a file by this text, at once."""
    with replacing(path) as file:
        file.write(text.encode("utf-8", "replace"))
    return path


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """Open a file that takes the place of `path` when the block has ended well."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(path.name + ".part")
    try:
        with part.open("wb") as file:
            yield file
        part.replace(path)
    except BaseException:  # a full disk: half a file would only take more of it
        part.unlink(missing_ok=True)
        raise
