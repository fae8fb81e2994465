"""What to say about a file that Python can't read, by the kind of the error.

Since Python 3.10 a bracket that is never closed is named with its line, so no line before is
suspected. The sentences on notebooks, chats and pages are about what people paste.
"""

from __future__ import annotations

import re

QUOTES = "\u2018\u2019\u201c\u201d\u201e\u201a\u00ab\u00bb\u2032\u2033"
DASHES = "\u2010\u2011\u2013\u2014\u2212"
BLANKS = "\N{NO-BREAK SPACE}\N{ZERO WIDTH SPACE}\N{NARROW NO-BREAK SPACE}\N{BYTE ORDER MARK}"
NOTEBOOK = "the file holds Python only, no line of a notebook: delete it"

# what the line begins with or holds: what to do
LINES = (
    (r"^```", "``` is Markdown, around code in a chat or a page: delete each such line"),
    (r"^%%?\w", NOTEBOOK),
    (r"^!", f"{NOTEBOOK}; commands such as pip belong into a terminal"),
    (r"^(<{7}|={7}|>{7})", "Git left a conflict here: keep one of the two parts, and no marks"),
    (r"^>>>|^\.\.\. |^(In|Out) ?\[\d*\]:", "the prompt was copied, too: delete it, keep the code"),
    (r"^\d+[.:)]?\s+(def|class|import|from|if|for|while|return|self)\b",
     "the numbers of the lines were copied, too: delete them"),
    (r"\+\+|--\s*$", "Python has no ++ and --: x += 1"),
    (r"&&|\|\|", "Python writes `and` and `or`"),
    (r"^\}?\s*else\s+if\b", "Python writes `elif`"),
    (r"(?<![=<>!\"'])!(?![=\"'r])\s*\w", "Python writes `not`"),
    (r"^(public|private|void|int|float|double|auto|const|var|let)\s+\w+", "a name needs no type "
     "before it: x = 0"),
    (r"^(function|func|fn)\s", "a function begins with `def`"),
    (r"^(if|elif|while)\b([^=()]|[=!<>]=|\([^()]*\))*(?<![=!<>:])=(?!=)",
     "a comparison is written ==: a single = gives a value"),
    (r"<>", "Python writes `!=`"),
)  # fmt: skip

# what Python says: what to do
KINDS = (
    (r"Missing parentheses in call to '(print|exec)", "this is Python 2's: write \\1(…)"),
    (r"multiple exception types must be parenthesized", "this is Python 2's: `except X as error:`"),
    (r"inconsistent use of tabs", "indent with four spaces everywhere, never with tabs"),
    (r"unindent does not match", "this line is indented less than its block, and like none around "
     "it: use four spaces for each level"),
    (r"unexpected indent", "this line is indented more than the one before, which ends without a "
     "colon: begin it where its block begins"),
    (r"expected an indented block after (.*)", "what belongs to \\1 is missing, or isn't "
     "indented by four spaces; `pass` says that there is nothing to do"),
    (r"unterminated triple-quoted", 'three quotes open a text that no three quotes close: """'),
    (r"unterminated (f-)?string", "the text isn't closed by the quote that opened it"),
    (r"'(.)' was never closed", "the bracket \\1 that opens here is never closed"),
    (r"unmatched '(.)'", "\\1 closes what nothing opened: is there one too many?"),
    (r"closing parenthesis '(.)' does not match opening parenthesis '(.)'",
     "\\1 closes \\2: brackets close in pairs"),
    (r"Perhaps you forgot a comma", "a comma or an operator is missing between two values"),
    (r"expected ':'", "a line with if, else, for, while, def or class ends with a colon"),
    (r"Maybe you meant '==' or ':='|invalid syntax\. Maybe you meant '=='",
     "a comparison is written =="),
    (r"cannot assign to (.*?)(?: here)?(?:\.|$)",
     "what stands left of = must be a name, an attribute or an item, not \\1"),
    (r"invalid (decimal|hexadecimal|imaginary) literal", "a name can't begin with a digit, and a "
     "number takes no unit"),
    (r"leading zeros in decimal", "a number doesn't begin with 0: 5, not 05"),
    (r"'return' outside function|'yield' outside", "it isn't indented like the function's body"),
    (r"'(break|continue)' (outside loop|not properly in loop)", "\\1 belongs into a while or for"),
    (r"'await' outside async function", "only a function with `async def` awaits"),
    (r"unexpected character after line continuation", "a \\\\ continues a line only as its last "
     "character; in a path or text write / or quotes"),
    (r"positional argument follows keyword", "arguments with a name come after those without"),
    (r"f-string", "between the braces of an f-string stands an expression, with other quotes than "
     "those around the text"),
    (r"unicodeescape", "a \\\\ in a path begins an escape: write / or r'…'"),
    (r"non-default argument follows default|parameter without a default follows",
     "parameters with a default come last"),
    (r"Non-UTF-8|null bytes|encoding problem|codec can't decode|invalid or missing encoding",
     "save the file as UTF-8 in your editor"),
    (r"from __future__ imports must occur", "it has to be the first import of the file"),
)  # fmt: skip


def words_on_syntax(said: str, line: str) -> str:
    """Return advice on a SyntaxError, from its message and its line."""
    text = line.strip()
    if match := re.search(r"invalid (?:non-printable )?character '?(.)?'? ?\(?U\+(\w+)", said):
        return _on_character(chr(int(match[2], 16)))
    for code, advice in LINES:
        if said.startswith(("invalid", "unmatched", "expected ':'")) and re.search(code, text):
            return advice
    if text.count("{") > text.count("}") and (
        said.startswith("f-string: expecting '}'")  # until Python 3.11, which read it as a whole
        or ("forgot a comma" in said and re.search(r"\b[fF]['\"]", text))
    ):
        return "a { in this f-string is closed by no }"
    for kind, advice in KINDS:
        if match := re.search(kind, said):
            return match.expand(advice)
    return ""


def _on_character(character: str) -> str:
    if character in QUOTES:
        return f"{character} is a quote of a word processor or a web page: type \" or '"
    if character in DASHES:
        return f"{character} is a dash: type - for minus"
    if character in BLANKS or not character.isprintable():
        return "an invisible character was copied from a page: delete it and type a blank"
    return f"{character} was copied from a page, and Python has no such sign: type what it means"
