"""`drive` and `check`: ask the judge, and show its answer below the cell."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import msgspec

from grader.course.exercises import Exercise, find_exercise
from grader.errors import GraderError, InputError
from grader.notebook import orders
from grader.notebook.cells import MAGIC
from grader.notebook.child import JUDGE
from grader.notebook.frame import frame_html
from grader.notebook.kind import sentence
from grader.notebook.report import CheckReport
from grader.notebook.session import SESSION, exercise_of
from grader.notebook.show import Progress, preformatted, tell
from grader.notebook.written import age_of, other_cell


def drive_file(
    scenario: str,
    file: str | Path | None,
    lidar: str | None,
    *,
    goals: Sequence[tuple[float, float]],
    params: Mapping[str, str | bool | int | float],
    duration: float | None,
    seed: int | None,
    at: float | Sequence[float],
    callback: str,
) -> None:
    """See `grader.notebook.drive`."""
    try:
        path = SESSION.file_to_drive(file)
        order = orders.Drive(
            str(path),
            path.name,
            _scenario_name(scenario),
            lidar,
            _goals(goals),
            tuple(f"{name}:={_spell(value)}" for name, value in params.items()),
            None if duration is None else float(duration),
            seed,
            _libraries(path),
            _moments(at),
            str(callback),
        )
    except (InputError, GraderError) as error:
        tell(f"Not driven: {error}")
        return
    if not SESSION.written and file is None:
        tell(f"No %%node cell has run since this kernel started. {_written(path)}.")
    bar = Progress(f"{path.name} drives in {scenario}")
    _show_run(_ask(order, bar, "Not driven"), bar, f"Replay of {path.name} in {scenario}")


def check_file(name: str | None, file: str | Path | None, *, field: bool) -> CheckReport | None:
    """See `grader.notebook.check`."""
    try:
        exercise, only = _wanted(name, file)
        path = SESSION.file_for(exercise, file)
    except (InputError, GraderError) as error:
        tell(f"Not checked: {error}")
        return None
    written = _written(path)
    order = orders.Grade(exercise.slug, str(path), path.name, only, field)
    bar = Progress(f"Exercise {exercise.number}, {path.name}")
    answer = _ask(order, bar, "Not checked")
    if not isinstance(answer, orders.Graded):
        return None
    grading = msgspec.json.decode(answer.grading)
    report = CheckReport(
        grading, answer.text, answer.page, answer.first, answer.changed, written, other_cell(path)
    )
    bar.end(report.shown())
    return report


def search_file(
    name: str | None,
    file: str | Path | None,
    *,
    minutes: float | None,
    tries: int | None,
    seed: int,
    field: bool,
) -> None:
    """See `grader.notebook.search`."""
    try:
        exercise, _ = _wanted(name, file)
        path = SESSION.file_for(exercise, file)
        bounds = _bounds(minutes, tries)
        order = orders.Look(exercise.slug, str(path), path.name, *bounds, int(seed), field)
    except (InputError, GraderError) as error:
        tell(f"Not searched: {error}")
        return
    bar = Progress(f"Exercise {exercise.number}, {path.name}")
    _show_run(_ask(order, bar, "Not searched"), bar, f"Replay of {path.name}")


def _show_run(answer: orders.Answer | None, bar: Progress, title: str) -> None:
    if isinstance(answer, orders.Driven):
        said = answer.text.strip("\n")
        frame = frame_html(answer.page, title=title) if answer.page else ""
        bar.end({"text/plain": said, "text/html": preformatted(said) + frame})


def _bounds(minutes: float | None, tries: int | None) -> tuple[float | None, int | None]:
    if minutes is not None and not 0 < float(minutes) <= 600:
        raise InputError(f"minutes={minutes!r}: expected a number up to 600, such as 2")
    if tries is not None and int(tries) < 1:
        raise InputError(f"tries={tries!r}: expected a whole number, such as 200")
    return None if minutes is None else float(minutes), None if tries is None else int(tries)


def _written(path: Path) -> str:
    """Say when a file was written, and whether this kernel did it."""
    ours = SESSION.written.get(path.name, Path()).resolve() == path
    before = "" if ours else f", not by a {MAGIC} cell of this kernel: if the cell is newer, run it"
    return f"{path.name} was written {age_of(path)}{before}"


def _wanted(name: str | None, file: str | Path | None) -> tuple[Exercise, tuple[str, ...]]:
    """Return the exercise and the checks that "slug:check,check" asks for."""
    slug, _, checks = (name or "").partition(":")
    only = tuple(filter(None, (check.strip() for check in checks.split(","))))
    if ":" in (name or "") and not only:
        raise InputError(
            f"{name!r}: expected names of checks after the colon, as in "
            f'"{slug or 1}:wiring", or no colon'
        )
    if slug.strip():
        return find_exercise(slug.strip()), only
    if file is not None:
        exercise = exercise_of(Path(file).name)
        if exercise is not None:
            return exercise, only
    return SESSION.last_exercise(), only


def _ask(order: orders.Order, bar: Progress, failed: str) -> orders.Answer | None:
    """Ask the judge, with a bar below the cell; None (and a message) if it stopped or failed."""
    steps = _Steps()

    def on_progress(step: orders.Progressed) -> None:
        steps.note(step)
        bar.update(*steps.shown())

    try:
        answer = JUDGE.ask(order, on_progress, bar.beat)
    except KeyboardInterrupt:
        bar.say(f"{failed}: stopped, because you interrupted the kernel. Run the cell again.")
        return None
    except GraderError as error:
        answer = orders.Problem(str(error), fault=True)
    if not isinstance(answer, orders.Problem):
        return answer
    end = "\nThis is not your mistake. Run the cell again." if answer.fault else ""
    bar.say(f"{failed}: {sentence(answer.text)}{end}")
    return None


@dataclass
class _Steps:
    """How far a run is, for the bar below the cell."""

    running: dict[str, None] = field(default_factory=dict)  # scenarios, in order
    trials: tuple[int, int] = (0, 0)  # done, of
    checks: tuple[int, int] = (0, 0)
    outcomes: dict[str, str] = field(default_factory=dict)  # by check
    search: str = ""  # how far a search is

    def note(self, step: orders.Progressed) -> None:
        """Note a step."""
        if step.what == "world":
            self.trials, self.search = (step.done, step.of), step.name
            return
        if step.what != "trial":
            self.checks = step.done, step.of
            self.outcomes[step.name] = step.outcome
            return
        self.trials = step.done, step.of
        if step.outcome:
            self.running.pop(step.name, None)
        else:
            self.running[step.name] = None

    def shown(self) -> tuple[float, str]:
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


def _scenario_name(scenario: str) -> str:
    """Return a scenario's name, or its file's absolute path: the judge runs in another folder."""
    text = str(scenario)
    if text.endswith(".toml") or "/" in text:
        path = Path(text)
        if not path.is_file():
            raise InputError(f"{text}: there is no such scenario file here")
        return str(path.resolve())
    return text


def _goals(goals: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    try:
        return tuple((float(x), float(y)) for x, y in goals)
    except (TypeError, ValueError):
        raise InputError("goals: expected pairs (x, y) [m], such as [(5, 3), (0, 0)]") from None


def _moments(at: float | Sequence[float]) -> tuple[float, ...]:
    try:
        return tuple(map(float, at if isinstance(at, Sequence) else [at]))
    except (TypeError, ValueError):
        raise InputError(f"at={at!r}: expected a time [s], such as 4.2, or two") from None


def _spell(value: str | bool | int | float) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _libraries(path: Path) -> tuple[str, ...]:
    exercise = exercise_of(path.name)
    return () if exercise is None else exercise.libraries
