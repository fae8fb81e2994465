"""What the reader does: answer a question, watch a run, play with a figure, name a wrong line.

The pages are complete without scripts: then all is unfolded, and a replay is a link.
`_static/site.js` folds and asks.
"""

from __future__ import annotations

import html
import re
from typing import TYPE_CHECKING, Any

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

if TYPE_CHECKING:
    from collections.abc import Iterator

    from sphinx.application import Sphinx

LOG = logging.getLogger(__name__)
MARK = re.compile(r"\[([ x])\] ")  # of an option: wrong, right


def raw(text: str) -> nodes.raw:
    """Return HTML."""
    return nodes.raw("", text, format="html")


class Said(nodes.General, nodes.Element):
    """A place whose words are said elsewhere on the page; becomes a link to them."""


class Acting(SphinxDirective):
    """A directive with Markdown in it."""

    def parsed(self) -> list[nodes.Node]:
        """Return the content."""
        into = nodes.container()
        self.state.nested_parse(self.content, self.content_offset, into)
        return into.children

    def parsed_line(self, line: str) -> list[nodes.Node]:
        """Return a line of Markdown."""
        return self.state.inline_text(line, self.lineno)[0]


class Question(Acting):
    """A question, its options as a list: `[x]` or `[ ]`, and below each what it teaches.

    `:said:` quotes words of the sentence on this page that answers it.
    """

    required_arguments = 1
    final_argument_whitespace = True
    has_content = True
    option_spec = {"said": directives.unchanged_required}  # noqa: RUF012  (docutils' form)

    def run(self) -> list[nodes.Node]:
        """Return the question."""
        name = f"question-{self.env.new_serialno('question') + 1}"
        asked = self.parsed_line(self.arguments[0])
        listed = self.parsed()
        if len(listed) != 1 or not isinstance(listed[0], nodes.bullet_list):
            raise self.error("question: expected one list of options")
        options = [part for item in listed[0] for part in self.option(item)]
        if sum("data-right" in str(part) for part in options) != 1:
            raise self.error("question: expected one option with [x], the others with [ ]")
        return [
            raw(f'<div class="question" role="group" aria-labelledby="{name}">'),
            raw(f'<p class="ask" id="{name}">'),
            *asked,
            raw("</p><ol>"),
            *options,
            raw("</ol>"),
            raw('<p class="said">'),
            *([Said(quote=self.options["said"])] if "said" in self.options else []),
            raw('</p><p class="status" role="status"></p></div>'),
        ]

    def option(self, item: nodes.Element) -> Iterator[nodes.Node]:
        """Yield an option and its feedback."""
        first, *feedback = item.children
        mark = MARK.match(first.astext())
        if mark is None or not feedback:
            raise self.error("question: an option is `[ ]` or `[x]`, words, and feedback below")
        text = first.next_node(nodes.Text)
        text.parent.replace(text, nodes.Text(MARK.sub("", str(text), count=1)))
        right = " data-right" if mark[1] == "x" else ""
        yield raw(f'<li><button type="button" class="option"{right}>')
        yield from first.children
        yield raw('</button><div class="feedback">')
        yield from feedback
        yield raw("</div></li>")


class Answer(Acting):
    """A model answer, shown after the reader's own; an instructor may leave all of them out."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        """Return a place to write, and the model answer."""
        shown = self.env.config.course_model_answers
        number = self.env.new_serialno("answer") + 1
        own = f'<label for="own-{number}">Your answer</label><textarea id="own-{number}" rows="5">'
        parts: list[nodes.Node] = [raw(f'<div class="own-answer">{own}</textarea>')]
        if shown:
            summary = "<summary>Compare with a model answer</summary>"
            parts += [raw(f'<details class="model-answer">{summary}')]
            parts += [*self.parsed(), raw("</details>")]
        return [*parts, raw("</div>")]


class Watch(Acting):
    """A replay: of `course drive` with `:drive:`, or of a pitfall, `pitfalls/NAME`.

    `python -m grader.authoring.lesson_replays` makes the former.
    """

    required_arguments = 1
    has_content = True
    option_spec = {  # noqa: RUF012
        "drive": directives.unchanged_required, "plays": directives.flag,
    }  # fmt: skip

    def run(self) -> list[nodes.Node]:
        """Return the replay with its caption."""
        folder, _, name = self.arguments[0].rpartition("/")
        up = "../" * self.env.docname.count("/")
        place = f"{up}{folder}{'/' if folder else ''}replays/{name}.html"
        plays = " data-plays" if "plays" in self.options else ""
        link = f'<a class="watch" href="{place}"{plays}>Watch it drive</a>'
        caption = self.parsed()
        return [raw(f'<figure class="watched">{link}<figcaption>'), *caption,
                raw("</figcaption></figure>")]  # fmt: skip


class Play(Acting):
    """A figure to play with, drawn by `_static/play/NAME.js`; below it what to look for."""

    required_arguments = 1
    has_content = True

    def run(self) -> list[nodes.Node]:
        """Return the place of the figure, and what stands below it."""
        name = self.arguments[0]
        told = "<noscript>(A figure to play with; it needs JavaScript.)</noscript>"
        return [raw(f'<figure class="play" data-play="{html.escape(name)}">{told}<figcaption>'),
                *self.parsed(), raw("</figcaption></figure>")]  # fmt: skip


class Challenge(SphinxDirective):
    """Asks which line of the listing above is wrong; what follows on the page waits for a guess."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        """Return the form."""
        lines = html.escape(self.arguments[0])
        return [raw(
            f'<form class="challenge" data-lines="{lines}">'
            '<label for="line">Which line would you change?</label>'
            '<span><input id="line" type="number" min="1" inputmode="numeric" required>'
            '<button type="submit">That one</button>'
            '<button type="button" class="quiet">I do not know</button></span>'
            '<p class="status" role="status"></p></form>'
        )]  # fmt: skip


class LinkWhatIsSaid(SphinxPostTransform):
    """Turns `Said` into a link to the paragraph that has the quoted words."""

    default_priority = 6
    formats = ("html",)

    def run(self, **_: Any) -> None:
        """Go through the page."""
        for number, said in enumerate(list(self.document.findall(Said))):
            plain = re.sub(r"[*`]", "", said["quote"]).split()
            words = r"\s+".join(map(re.escape, plain)).replace("'", ".")  # which became curly
            texts = self.document.findall(nodes.TextElement)
            blocks = (text for text in texts if not isinstance(text, nodes.Inline))
            place = next((block for block in blocks if re.search(words, block.astext())), None)
            if place is None:
                LOG.warning("the page does not say %r", said["quote"], location=self.env.docname)
                said.parent.remove(said)
                continue
            place["ids"].append(f"said-{number}")
            place["classes"].append("said-here")
            said.replace_self(raw(f'<a href="#said-{number}">Where it says so</a>'))


def add_scripts(app: Sphinx, _n: str, _t: str, _p: dict, doctree: nodes.document | None) -> None:
    """Give a page the scripts of its figures."""
    made = "" if doctree is None else "".join(node.astext() for node in doctree.findall(nodes.raw))
    names = re.findall(r'data-play="(\w+)"', made)
    for name in dict.fromkeys(["kit", "data", *names] if names else []):
        app.add_js_file(f"play/{name}.js", loading_method="defer")


def setup(app: Sphinx) -> dict[str, Any]:
    """Tell Sphinx."""
    app.add_config_value("course_model_answers", True, "env", [bool, str])
    app.add_node(Said)
    for name, directive in (("question", Question), ("answer", Answer), ("watch", Watch),
                            ("play", Play), ("challenge", Challenge)):  # fmt: skip
        app.add_directive(name, directive)
    app.add_post_transform(LinkWhatIsSaid)
    app.connect("html-page-context", add_scripts)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
