"""Parameter files that no node reads: rclpy passes over sections with other names in silence."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import yaml

from ..frames import Note

PARAMETERS = "ros__parameters"


def unread(arguments: Sequence[str], nodes: Collection[str]) -> Iterator[Note]:
    """Yield a note on each file of a command line that has no section for any of these nodes.

    Parameters
    ----------
    arguments
        Of the program, with its `--params-file FILE`.
    nodes
        The full names of its nodes.
    """
    files = [file for flag, file in pairwise(arguments) if flag == "--params-file"]
    for file in dict.fromkeys(files if nodes else ()):
        sections = list(_sections(yaml.safe_load(Path(file).read_text("utf-8"))))
        if sections and not any(_is_for(section, node) for section in sections for node in nodes):
            yield Note("params", ", ".join(sections), Path(file).name, more=", ".join(nodes))


def _sections(tree: Any, above: str = "") -> Iterator[str]:
    for name, below in tree.items() if isinstance(tree, dict) else ():
        section = f"{above}/{str(name).strip('/')}"
        if isinstance(below, dict) and PARAMETERS in below:
            yield section
        else:
            yield from _sections(below, section)


def _is_for(section: str, node: str) -> bool:
    """Return whether a section means a node: `*` is one token of a name, `**` any number."""
    form = re.escape(section).replace(r"/\*\*", r"(/\w+)*").replace(r"/\*", r"/\w+")
    return re.fullmatch(form, node) is not None
