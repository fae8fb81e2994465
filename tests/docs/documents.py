"""The project's documents, as tests read them: prose, links, headings, code."""

import re
import subprocess
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from urllib.parse import unquote

from markdown_it import MarkdownIt
from markdown_it.token import Token

ROOT = Path(__file__).resolve().parents[2]
MARKDOWN = MarkdownIt().enable("table")
ATTRIBUTE = re.compile(r'\b(?:src|srcset|href)="([^"]+)"')
OUTPUT = "text"  # the language of fences that quote what a program printed


@lru_cache(maxsize=1)
def tracked() -> tuple[str, ...]:
    """Return the paths of all files of the project, ignored ones left out."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    paths = dict.fromkeys(listed.stdout.splitlines())  # in a merge, git names some three times
    return tuple(path for path in paths if (ROOT / path).is_file())


@dataclass(frozen=True)
class Document:
    """A Markdown file."""

    path: str  # below the project's root

    @property
    def file(self) -> Path:
        return ROOT / self.path

    @cached_property
    def blocks(self) -> list[Token]:
        return MARKDOWN.parse(self.file.read_text("utf-8"))

    def parts(self, *kinds: str) -> Iterator[Token]:
        """Yield the parts of these kinds, in paragraphs, headings and tables too."""
        for block in self.blocks:
            yield from (part for part in (block, *(block.children or ())) if part.type in kinds)

    @property
    def prose(self) -> str:
        return " ".join(block.content for block in self.blocks if block.type == "inline")

    @property
    def links(self) -> list[str]:
        """The targets of links and pictures."""
        found = [part.attrs.get("href", part.attrs.get("src"))
                 for part in self.parts("link_open", "image")]  # fmt: skip
        html = "".join(part.content for part in self.parts("html_block", "html_inline"))
        return [unquote(str(link)) for link in found] + ATTRIBUTE.findall(html)

    @property
    def spans(self) -> list[str]:
        """What stands in backticks."""
        return [part.content.strip() for part in self.parts("code_inline")]

    @property
    def code(self) -> list[str]:
        """Spans, and the lines of code blocks that are no quoted output."""
        blocks = (part for part in self.parts("fence", "code_block") if part.info != OUTPUT)
        return self.spans + [line.strip() for b in blocks for line in b.content.splitlines()]

    @property
    def anchors(self) -> set[str]:
        """The anchors that GitHub makes of the headings."""
        after = zip(self.blocks, self.blocks[1:], strict=False)
        return {anchor(text.content) for block, text in after if block.type == "heading_open"}


def anchor(heading: str) -> str:
    """Return GitHub's anchor of a heading."""
    text = re.sub(r"[*`]", "", heading).strip().lower()
    kept = (c for c in text if c in " -_" or unicodedata.category(c)[0] in "LN")
    return "".join(kept).replace(" ", "-")


def documents(*patterns: str) -> list[Document]:
    """Return the Markdown files that begin with one of these paths; without any, all."""
    found = [path for path in tracked() if path.endswith(".md")]
    return [Document(path) for path in found if not patterns or path.startswith(patterns)]
