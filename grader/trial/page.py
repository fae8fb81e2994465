"""Recordings in a browser: what a page's judge has, and what no page can record."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from grader.course.installed import OPTIONAL
from grader.models.files import needed_for
from grader.recording import Recording
from grader.trial.trials import SavedTrials
from sim.scenario_files import load_scenario

SEVERAL = (
    "Several programs run in it, for which a browser needs JSPI (WebAssembly.Suspending): this one "
    "has none. The installed course judges it."
)


class PageTrials(SavedTrials):
    """Recordings of what runs without any of the optional libraries, none of which a page has.

    Without `stacks` that can wait for a promise no scenario of several programs runs, either.
    """

    def __init__(self, recordings: Iterable[Recording], stacks: bool = True) -> None:
        super().__init__(recordings)
        self._stacks = stacks

    def lacks(self, scenarios: Sequence[str], libraries: Sequence[str]) -> str:
        """Say which libraries a check wants, or the models of its scenarios; empty if none."""
        models = [load_scenario(name).node.models for name in scenarios]
        needed = dict.fromkeys([*libraries, *(each for m in models for each in needed_for(m))])
        names = ", ".join(OPTIONAL[module][0] for module in needed)
        if names:
            return f"Only the installed course judges this: it needs {names}."
        several = any(load_scenario(name).program for name in scenarios)
        return SEVERAL if several and not self._stacks else ""
