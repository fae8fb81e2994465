"""How far a grading is, for the bar below a cell: what runs, what has passed."""

from __future__ import annotations

from dataclasses import dataclass, field

from grader.notebook.orders import Progressed

TRIAL, WORLD = "trial", "world"


@dataclass
class Steps:
    """What the judge has told so far."""

    running: dict[str, None] = field(default_factory=dict)  # scenarios, in order
    trials: tuple[int, int] = (0, 0)  # done, of
    checks: tuple[int, int] = (0, 0)
    outcomes: dict[str, str] = field(default_factory=dict)  # by check
    search: str = ""  # how far a search is

    def note(self, step: Progressed) -> None:
        """Note a step."""
        if step.what == WORLD:
            self.trials, self.search = (step.done, step.of), step.name
            return
        if step.what != TRIAL:
            self.checks = step.done, step.of
            self.outcomes[step.name] = step.outcome
            return
        self.trials = step.done, step.of
        if step.outcome:
            self.running.pop(step.name, None)
        else:
            self.running[step.name] = None

    def told(self) -> tuple[float, str]:
        """Return the progress as a share, 0 … 1, and in words."""
        (trials, all_trials), (checks, all_checks) = self.trials, self.checks
        if self.search:
            return trials / all_trials if all_trials else 0.0, self.search
        parts = [f"{trials} of {all_trials} runs"] if all_trials else []
        parts += [f"running {', '.join(self.running)}"] if self.running else []
        parts += [
            f"{count} {word}"
            for word in ("passed", "failed")
            if (count := list(self.outcomes.values()).count(word[:4]))
        ]
        total = all_trials + all_checks
        return (trials + checks) / total if total else 0.0, ", ".join(parts)
