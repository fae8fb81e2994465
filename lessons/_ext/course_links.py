"""Links to ../exercises, right where the sources are read, lead to the pages made of them.

On GitHub and in a students' release the exercises lie beside the lesson; on the site, below it.
A link to the glossary becomes one to the word's entry there. A link to a skeleton, which lies
beside its README, becomes a download. Skeletons of exercises in `course_left_out` stay behind: a
release may leave exercises out.
"""

from __future__ import annotations

import html
import re
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

ROOT = Path(__file__).resolve().parents[2]


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


def to_notebook(
    app: Sphinx, name: str, _template: str, page: dict[str, Any], _tree: object
) -> None:
    """Link an exercise's notebook at the instructor's address, below the heading of its page."""
    folder, _, rest = name.partition("/")
    slug = rest.removesuffix("/README")
    left_out = app.config.course_left_out.split(",")
    if folder != "exercises" or slug == rest or slug in left_out or not app.config.course_colab:
        return
    about = tomllib.loads((ROOT / "exercises" / slug / "exercise.toml").read_text("utf-8"))
    (notebook,) = (ROOT / "notebooks" / "text").glob(f"{about['number']:02}_*")
    address = html.escape(f"{app.config.course_colab.rstrip('/')}/{notebook.name}.ipynb")
    link = f'<p class="notebook"><a href="{address}">Open its notebook in Colab</a></p>'
    page["body"] = page["body"].replace("</h1>", f"</h1>{link}", 1)


def setup(app: Sphinx) -> dict[str, Any]:
    """Tell Sphinx."""
    app.add_config_value("course_left_out", "", "env", [str])  # slugs, with commas
    app.connect("source-read", to_pages)
    app.add_config_value("course_colab", "", "html", [str])  # where the released notebooks lie
    app.connect("include-read", to_skeletons)
    app.connect("html-page-context", to_notebook)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
