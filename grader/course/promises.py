"""Which checks hold a node to what a README says: `<!-- checks: stop_zone, blind -->`.

The comment stands behind a sentence, or at the end of a table's last cell; readers don't see it.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from pathlib import Path

from grader.errors import InputError
from sim.toml_input import nearest

COMMENT = re.compile(r"\s*<!-- checks:(?P<names>.*?)-->", re.DOTALL)


def promised(readme: Path, known: Collection[str]) -> frozenset[str]:
    """Return the checks that the comments of a README name.

    Raises InputError: a name is not one of the known checks.
    """
    text = readme.read_text("utf-8")
    found = set()
    for comment in COMMENT.finditer(text):
        for name in comment["names"].replace(",", " ").split():
            if name not in known:
                line = text.count("\n", 0, comment.start("names")) + 1
                raise InputError(f"{readme}:{line}: no check {name!r}{nearest(name, known)}")
            found.add(name)
    return frozenset(found)


def without_promises(text: str) -> str:
    """Return a README's text without these comments."""
    return COMMENT.sub("", text)
