"""What Sphinx and furo leave out for readers with a screen reader or a keyboard.

Checked with axe-core in tests/lessons/test_site_in_browser.py.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

CAPTION = 'class="caption" role="heading"'  # Sphinx's captions of the contents: of which level?


def give_captions_a_level(_: Sphinx, _name: str, _template: str, page: dict, _tree: object) -> None:
    """Below the page's own heading, which is of level 1."""
    for key in ("furo_navigation_tree", "body"):
        if page.get(key):
            page[key] = page[key].replace(CAPTION, f'{CAPTION} aria-level="2"')


def setup(app: Sphinx) -> dict[str, Any]:
    """Tell Sphinx."""
    app.connect("html-page-context", give_captions_a_level, priority=900)  # after furo
    return {"parallel_read_safe": True, "parallel_write_safe": True}
