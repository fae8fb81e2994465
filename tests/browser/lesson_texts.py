"""What the lesson's pages say that a drive prints."""

import re

from grader.course.exercises import ROOT

ELISION = "…"


def shown_below(page: str, command: str) -> list[str]:
    """Return the lines of the output below a command, without those that stand for others."""
    text = re.sub(r" \\\n +", " ", (ROOT / "lessons" / f"{page}.md").read_text("utf-8"))
    at = re.escape(f"```console\n$ course drive {command}\n```\n\n```output")
    found = re.search(at + r"(?: log)?\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    assert found, f"lessons/{page}.md: expected {command} with its output"
    return [line for line in found[1].splitlines() if line and line != ELISION]
