"""The project's documents, as tests read them: lines, links, headings, commands."""

from __future__ import annotations

import re
import subprocess
import unicodedata
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FENCE = re.compile(r"^\s*(`{3,}|~{3,})\s*(\S*)")
SPAN = re.compile(r"(`+)(?!`)(.+?)(?<!`)\1(?!`)")
LINK = re.compile(r"!?\[[^\]]*\]\(([^()\s]+)\)")
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
class Line:
    """One line, and what it is part of."""

    number: int  # from 1
    text: str
    fence: str | None  # the language of the fence that it is in; None in prose

    @property
    def indented(self) -> bool:
        """It is code by its four blanks (or more, in a list)."""
        return self.fence is None and self.text.startswith("    ")


@dataclass(frozen=True)
class Document:
    """A Markdown file."""

    path: str  # below the project's root

    @property
    def file(self) -> Path:
        return ROOT / self.path

    @cached_property
    def lines(self) -> list[Line]:
        found = []
        fence, mark = None, ""
        for number, text in enumerate(self.file.read_text("utf-8").splitlines(), start=1):
            match = FENCE.match(text)
            if fence is None and match:
                fence, mark = match[2], match[1]
                found.append(Line(number, text, fence))
            elif fence is not None and match and match[1].startswith(mark) and not match[2]:
                found.append(Line(number, text, fence))
                fence = None
            else:
                found.append(Line(number, text, fence))
        return found

    @cached_property
    def prose(self) -> str:
        """The text without code blocks and comments."""
        kept = "\n".join(x.text for x in self.lines if x.fence is None and not x.indented)
        return re.sub(r"<!--.*?-->", "", kept, flags=re.DOTALL)

    @property
    def links(self) -> list[str]:
        """The targets of links and pictures."""
        text = SPAN.sub("", self.prose)
        return LINK.findall(text) + ATTRIBUTE.findall(text)

    @property
    def spans(self) -> list[str]:
        """What stands in backticks."""
        return [match[2].strip() for match in SPAN.finditer(self.prose.replace("\n", " "))]

    @property
    def code(self) -> list[str]:
        """Spans, and the lines of code blocks that are no quoted output."""
        blocks = [x.text.strip() for x in self.lines if x.indented or x.fence not in (None, OUTPUT)]
        return self.spans + blocks

    @property
    def anchors(self) -> set[str]:
        """The anchors that GitHub makes of the headings."""
        return {
            anchor(line.text.lstrip("#"))
            for line in self.lines
            if line.fence is None and re.match(r"#{1,6} ", line.text)
        }


def anchor(heading: str) -> str:
    """Return GitHub's anchor of a heading."""
    text = re.sub(r"[*`]", "", heading).strip().lower()
    kept = (c for c in text if c in " -_" or unicodedata.category(c)[0] in "LN")
    return "".join(kept).replace(" ", "-")


def documents(*patterns: str) -> list[Document]:
    """Return the Markdown files that begin with one of these paths; without any, all."""
    found = [path for path in tracked() if path.endswith(".md")]
    return [Document(path) for path in found if not patterns or path.startswith(patterns)]
