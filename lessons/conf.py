"""Sphinx: the lesson as a site that needs no network. `make site` builds it."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parent / "_ext")]

project = "Bridging Python agents with rclpy"
html_title = project
author = "The authors of rclpy-agents-course"
language = "en"

extensions = [
    "myst_parser",
    "contract_role",
    "drawings",
    "offline_math",
    "course_links",
    "accessible",
    "acts",
    "notebook_here",
    "workspace_block",
    "drive_here",
]
myst_enable_extensions = ["attrs_inline", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
nitpicky = True

# The quiz holds the rubric: its questions come into check_your_understanding.md without it.
exclude_patterns = ["quiz.md", "figures/**"]

html_theme = "furo"
html_static_path = ["_static"]
html_favicon = "_static/favicon.svg"
html_css_files = ["site.css"]
html_js_files = [("site.js", {"defer": "defer"})]
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
html_show_search_summary = False  # fetched pages, which a browser refuses where no server is
html_last_updated_fmt = None  # the same sources, the same site
html_show_copyright = False
pygments_style = "a11y-high-contrast-light"
pygments_dark_style = "github-dark"

_LIGHT = {
    "blue": "#0b5cad",
    "green": "#1f7a3d",
    "orange": "#a34a00",
    "red": "#b3261e",
    "grey": "#5c6470",
    "shade": "#eef1f5",
}
_DARK = {
    "blue": "#7db8f5",
    "green": "#7fd19a",
    "orange": "#f2a96b",
    "red": "#f4958d",
    "grey": "#a8b0bb",
    "shade": "#23282f",
}
html_theme_options = {
    "light_css_variables": {
        "font-stack": "system-ui, sans-serif",
        "font-stack--monospace": "ui-monospace, monospace",
        "color-code-background": _LIGHT["shade"],
        "color-brand-primary": "#0b66a8",
        "color-brand-content": "#0b66a8",
        **{f"drawing-{name}": colour for name, colour in _LIGHT.items()},
    },
    "dark_css_variables": {
        "color-code-background": _DARK["shade"],
        "color-background-primary": "#0f1419",
        "color-background-secondary": "#171d24",
        "color-background-border": "#2a333d",
        "color-brand-primary": "#62b3ee",
        "color-brand-content": "#62b3ee",
        **{f"drawing-{name}": colour for name, colour in _DARK.items()},
    },
    "footer_icons": [],
    "top_of_page_buttons": [],
    "navigation_with_keys": False,  # the arrows belong to the replays
}
html_context = {
    "licence_note": "Lesson text and figures: CC BY 4.0 (LICENSE-lessons.md). Code: Apache-2.0.",
}
templates_path = ["_templates"]
