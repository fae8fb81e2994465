"""What version 1.0.0 had and what replaces it, said in a sentence."""

from __future__ import annotations

from collections.abc import Sequence

# A command, an option of it ("" for all of it), and the sentence
GONE = {
    ("delay", ""): "course delay is gone; set command_latency, scan_latency and odom_latency of "
    "[faults] in a scenario, and try it with course drive",
    ("autograde", "--earlier"): "--earlier is gone; sources/ has what was handed in, for Dolos or "
    "JPlag, which compare it with an earlier year's, too (docs/grading-a-class.md)",
    ("autograde", "--nbgrader"): "--nbgrader is gone; nbgrader autograde writes the judge's points "
    "into its own gradebook (notebooks/README.md), and scores.csv has them for any other",
}


def what_replaces(words: Sequence[str]) -> str:
    """Return the sentence for the first of these words that is gone; "" if none is."""
    command = words[0] if words else ""
    options = (word.partition("=")[0] for word in words[1:])
    return next((GONE[command, each] for each in ("", *options) if (command, each) in GONE), "")
