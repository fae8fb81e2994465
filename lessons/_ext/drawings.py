"""SVG images become part of the page, so that they follow its colours and are read aloud.

An <img> knows neither the page's light or dark, nor do screen readers see its text.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from docutils import nodes
from sphinx.transforms.post_transforms import SphinxPostTransform

if TYPE_CHECKING:
    from sphinx.application import Sphinx


class InlineDrawings(SphinxPostTransform):
    """Replaces each image of an SVG file by the file's text."""

    default_priority = 5  # before images are collected
    formats = ("html",)

    def run(self, **_: Any) -> None:
        """Go through the page."""
        for image in list(self.document.findall(nodes.image)):
            if not image["uri"].endswith(".svg"):
                continue
            file = Path(self.env.srcdir) / image["uri"]
            self.env.note_dependency(str(file))
            drawing = nodes.raw("", f'<div class="drawing-frame">{file.read_text("utf-8")}</div>')
            drawing["format"] = "html"
            image.replace_self(drawing)


def setup(app: Sphinx) -> dict[str, Any]:
    """Tell Sphinx."""
    app.add_post_transform(InlineDrawings)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
