"""The lesson's pages as the tests see them: prose, and fenced blocks."""

import functools
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).parents[2]
LESSONS = ROOT / "lessons"
sys.path[:0] = [path for path in [str(LESSONS)] if path not in sys.path]

PAGES = sorted(path for path in LESSONS.glob("*.md") if path.name != "quiz.md")
FENCE = re.compile(r"(?ms)^```(?P<info>[^\n`]+)\n(?P<body>.*?)^```$")
QUESTION = re.compile(r"(?ms)^:::\{question\} (?P<body>.*?)^:::$")
OPTION = re.compile(r"^:([\w-]+): ?(.*)$")


@dataclass(frozen=True)
class Block:
    """A fenced block of a page."""

    page: str
    line: int
    info: str  # "python", "console", "output", "output log"; of a directive its argument, too
    text: str
    options: dict[str, str] = field(default_factory=dict)

    @property
    def place(self) -> str:
        """Where it stands."""
        return f"lessons/{self.page}.md:{self.line}"


@functools.cache
def blocks(page: Path) -> list[Block]:
    """Return the fenced blocks of a page, in order."""
    source = page.read_text("utf-8")
    found = []
    for match in FENCE.finditer(source):
        info, body = match["info"].strip(), match["body"]
        options = {}
        if info.startswith("{"):
            lines = body.splitlines(keepends=True)
            while lines and (option := OPTION.match(lines[0].rstrip("\n"))):
                options[option[1]] = option[2]
                lines.pop(0)
            body = "".join(lines).removeprefix("\n")
            info = info.replace("{code-block} ", "")
        line = source[: match.start()].count("\n") + 1
        found.append(Block(page.stem, line, info, body, options))
    return found


def prose(page: Path) -> list[tuple[int, str]]:
    """Return (line number, text) of what a page says in words: no code, no numbers by role.

    Nor questions, whose numbers are examples: test_reading.py computes their answers.
    """
    source = page.read_text("utf-8")

    def blank(match: re.Match[str]) -> str:
        return re.sub(r"[^\n]", " ", match[0])

    def blank_code(match: re.Match[str]) -> str:
        kind = match["info"].strip().replace("{code-block} ", "").strip("{}").split()[0]
        return blank(match) if kind in ("python", "console", "output") else match[0]

    source = QUESTION.sub(blank, FENCE.sub(blank_code, source))
    source = re.sub(r"\{contract\}`[^`]+`", blank, source)
    source = re.sub(r"`[^`\n]+`", blank, source)
    return list(enumerate(source.splitlines(), 1))
