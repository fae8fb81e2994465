"""What a search came to, as its reader sees it in a terminal or a notebook."""

from __future__ import annotations

from grader.drive.mishaps import Mishap
from grader.drive.search.finder import Search

MINUTES = 1.0  # that a search takes if nobody says


def account(result: Search, *, exercise: int, seed: int) -> str:
    """Return the sentence, the world as a file, and how many worlds were tried."""
    found, tries = result.found, result.tries
    count = f"{tries} worlds" if tries != 1 else "one world"
    if found is None:
        early = " before it was interrupted" if result.interrupted else ""
        return (
            f"Nothing found in {count} (exercise {exercise}, seed {seed}){early}. That is no "
            "proof: another seed tries others."
        )
    early = ", interrupted" if result.interrupted else ""
    return (
        f"{found.sentence}\n\n{found.toml}\n"
        f"The smallest of {count} (exercise {exercise}, seed {seed}{early})."
    )


def how_far(tries: int, mishap: Mishap | None) -> str:
    """Return how far a search is, in a few words."""
    said = f": {mishap.text}; now looking for a smaller world" if mishap else ""
    return f"world {tries}{said}"
