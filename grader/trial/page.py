"""Recordings in a browser: what a page's judge has, and what no page can record."""

from __future__ import annotations

from collections.abc import Sequence

from grader.course.installed import OPTIONAL
from grader.models.files import needed_for
from grader.trial.trials import SavedTrials
from sim.scenario_files import load_scenario


class PageTrials(SavedTrials):
    """Recordings of what runs without any of the optional libraries, none of which a page has."""

    def lacks(self, scenarios: Sequence[str], libraries: Sequence[str]) -> str:
        """Say which libraries a check wants, or the models of its scenarios; empty if none."""
        models = [load_scenario(name).node.models for name in scenarios]
        needed = dict.fromkeys([*libraries, *(each for m in models for each in needed_for(m))])
        names = ", ".join(OPTIONAL[module][0] for module in needed)
        return f"Only the installed course judges this: it needs {names}." if names else ""
