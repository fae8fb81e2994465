"""Links to ../exercises, right where the sources are read, lead to the pages made of them.

On GitHub and in a students' release the exercises lie beside the lesson; on the site, below it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx


def to_pages(_: Sphinx, name: str, source: list[str]) -> None:
    """Rewrite the links of a page of the lesson."""
    if "/" not in name:
        source[0] = source[0].replace("](../exercises/", "](exercises/")


def setup(app: Sphinx) -> dict[str, Any]:
    """Tell Sphinx."""
    app.connect("source-read", to_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
