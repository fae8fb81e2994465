"""Links to ../exercises, right where the sources are read, lead to the pages made of them.

On GitHub and in a students' release the exercises lie beside the lesson; on the site, below it.
A link to the glossary becomes one to the word's entry there. A link to a skeleton, which lies
beside its README, becomes a download. Skeletons of exercises in `course_left_out` stay behind: a
release may leave exercises out.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path

    from sphinx.application import Sphinx


def to_pages(_: Sphinx, name: str, source: list[str]) -> None:
    """Rewrite the links of a page of the lesson."""
    if "/" not in name:
        source[0] = source[0].replace("](../exercises/", "](exercises/")


def to_skeletons(app: Sphinx, included: Path, _name: str, text: list[str]) -> None:
    """Rewrite the links of an exercise's README to its Python files, and to the glossary."""
    if included.name != "README.md":
        return
    text[0] = re.sub(r"\[([^\]]+)\]\(\.\./glossary\.md\)", r"{term}`\1`", text[0])
    name = included.parent.name
    if name in app.config.course_left_out.split(","):
        text[0] = re.sub(r"\[([^\]]*)\]\(\w+\.py\)", r"\1", text[0])
        return
    text[0] = re.sub(r"\]\((\w+\.py)\)", rf"](../../../exercises/{name}/\1)", text[0])


def setup(app: Sphinx) -> dict[str, Any]:
    """Tell Sphinx."""
    app.add_config_value("course_left_out", "", "env", [str])  # slugs, with commas
    app.connect("source-read", to_pages)
    app.connect("include-read", to_skeletons)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
