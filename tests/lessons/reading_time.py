"""How long a page takes a reader with English as a second language (`index.md` says the rates)."""

import re

WORDS = 150  # a minute
CODE = {"python": 15} | dict.fromkeys(("console", "sh", "yaml", "text", "output"), 30)  # lines
ACTS = {"{question}": 0.75, "{play}": 0.75, "{watch}": 0.5, "{figure}": 0.3, "{answer}": 3.0}
IN_THE_ACT = {"{toctree}", "{include}", "{question}", "{answer}"}  # their words are not counted
FENCED = re.compile(r"(?ms)^(`{3,}|:{3,})(?P<info>[^\n]+)\n(?P<body>.*?)^\1$")
FOLDED = re.compile(r"(?s)<details(?:(?!<details).)*?</details>")
NOT_READ = re.compile(r"(?m)\]\([^)]*\)|^:[\w-]+:.*$|^\|[-| ]+\|$|</?\w[^>\n]*>")


def unfolded(source: str) -> str:
    """Return a page without what a reader has to unfold."""
    while (shorter := FOLDED.sub("", source)) != source:
        source = shorter
    return source


def minutes(source: str) -> float:
    """Return how long a page takes [min]."""
    taken = 0.0

    def count(block: re.Match[str]) -> str:
        nonlocal taken
        kind = block["info"].replace("{code-block} ", "").split()[0]
        if kind in CODE:
            taken += sum(bool(line.strip()) for line in block["body"].splitlines()) / CODE[kind]
            return ""
        taken += ACTS.get(kind, 0.0)
        return "" if kind in IN_THE_ACT else block["body"]

    words = NOT_READ.sub(" ", FENCED.sub(count, source))
    return taken + len(re.findall(r"\S*\w\S*", words)) / WORDS
