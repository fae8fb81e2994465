"""Make others' ways of an exercise: two variants, with what each costs and gains.

`python -m grader.authoring.ways OUT [EXERCISE …]` writes `OUT/EXERCISE.json`. The two are those
whose texts differ most, from the reference and from each other. Every figure is of runs made here
and now. The page shows them after full marks (`workspace/web/ways.js`); `course release` leaves
them out unless it is asked.
"""

from __future__ import annotations

import ast
import itertools
import json
import re
import sys
from collections.abc import Sequence
from difflib import SequenceMatcher
from pathlib import Path
from typing import Any

import numpy as np

from grader.claims.claims import Claim, claims, grade_claim
from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.drive.race import lap_of, unit_of
from grader.errors import GraderError
from grader.exercises import contract_of
from grader.grading.grading import Grading
from grader.grading.plugin import PASS
from grader.launchers import ForkServerPool, launcher_pool
from grader.recording import Recording
from grader.recording.costs import costs_of

CLAIM = re.compile(r'\n\n(?:file|field):.*?\n(?=""")', re.DOTALL)  # of a variant, for the proof
CLOSE = 0.01  # [m]
FEW, APART = 0.1, 0.02  # of the lines, of a race's figure: less is not told apart
SAME = 1 / 3  # of a time: less is not told apart, for the machine has other things to do, too


def ways_of(exercise: Exercise, servers: ForkServerPool) -> list[dict[str, Any]]:
    """Return two ways, for JSON: what they are `about`, their `files`, and what is `said` of them.

    Raises GraderError: one of them has not all points.
    """
    found = [each for each in claims(exercise) if each.kind in ("reference", "variant")]
    reference, *others = (each for each in found if not each.lacks)
    pairs = itertools.combinations(others, 2)
    chosen = max(pairs, key=lambda pair: min(itertools.starmap(_apart, (
        (reference, pair[0]), (reference, pair[1]), pair))))  # fmt: skip
    launcher = servers.of(exercise.libraries)
    base, *graded = (grade_claim(each, launcher) for each in (reference, *chosen))
    made = []
    for way, grading in zip(chosen, graded, strict=True):
        if not grading.whole:
            raise GraderError(f"{way.name}: expected all points, got {grading.score}")
        laps, unit = _laps(grading, base), unit_of(exercise)
        driven = sum(lap for _, lap, _ in laps), sum(past for _, _, past in laps)
        lines, others_lines = len(_code(way)), len(_code(reference))
        said = [
            _balance(
                ("lines", lines, others_lines, FEW),
                ("ms of CPU a message", _cost(grading), _cost(base), SAME),
                ("s on its ways", *driven, APART if unit == "s" else 1.0),
                ("field checks", len(_failed(grading)), len(_failed(base)), 0),
            ),
            f"{lines} lines of code; the reference has {others_lines}.",
            _time(_cost(grading), _cost(base)),
            _runs(grading, base),
            *(f"{name}: {lap:.1f} {unit}; the reference {past:.1f} {unit}."
              for name, lap, past in laps if abs(lap - past) > APART * past),
            _field(grading),
        ]  # fmt: skip
        files = {name: CLAIM.sub("", text) for name, text in way.files.items()}
        about = way.about.removeprefix("Style: ")
        made.append({"about": about[0].upper() + about[1:], "said": said, "files": files})
    return made


def _apart(one: Claim, other: Claim) -> float:
    """Return which part of two texts' lines differs."""
    a, b = map(_code, (one, other))
    return 1 - SequenceMatcher(None, a, b, autojunk=False).ratio()


def _code(claim: Claim) -> list[str]:
    """Return the lines of code: without docstrings, comments and blank lines, as ways.js does."""
    code = []
    for text in claim.files.values():
        texts = (each for each in ast.walk(ast.parse(text)) if isinstance(each, ast.Expr)
                 and isinstance(each.value, ast.Constant))  # fmt: skip
        said = {line for each in texts for line in range(each.lineno, (each.end_lineno or 0) + 1)}
        code += [line for i, line in enumerate(text.splitlines(), 1)
                 if i not in said and re.match(r"\s*[^\s#]", line)]  # fmt: skip
    return code


def _balance(*figures: tuple[str, float, float, float]) -> str:
    """Say what a way saves and costs: of each its name, a figure, the reference's, what is equal.

    Less is better. What counts as equal is a share of the larger one.
    """
    apart = [(name, round(b - a, 2)) for name, a, b, of in figures if abs(b - a) > of * max(a, b)]
    if not apart:
        return "It saves and costs nothing that is measured: what differs is the style."
    saves = [f"{by:g} {name}" for name, by in apart if by > 0]
    costs = [f"{-by:g} {name}" for name, by in apart if by < 0]
    saved, cost = (", ".join(said) or "nothing that is measured" for said in (saves, costs))
    return f"Beside the reference it saves {saved}. It costs {cost}."


def _cost(grading: Grading) -> float:
    """Return the median of what a message of the robot costs in CPU time, over all runs [ms]."""
    costs = [costs.p50 for each in grading.recordings if (costs := costs_of(each))]
    return float(np.median(costs)) * 1e3 if costs else 0.0


def _time(mine: float, theirs: float) -> str:
    said = f"A message of the robot costs {mine:.2g} ms of CPU, with all that follows"
    if abs(mine - theirs) <= SAME * max(mine, theirs):
        return f"{said}: what it costs the reference, as far as that can be measured."
    return f"{said}; the reference {theirs:.2g} ms."


def _runs(mine: Grading, theirs: Grading) -> str:
    other = {each.name: each for each in theirs.recordings}
    count = len(mine.recordings)
    differ = [each for each in mine.recordings if _sent(each) != _sent(other[each.name])]
    if not differ:
        return f"In all {count} runs it sends what the reference sends, message for message."
    names = ", ".join(each.name for each in differ[:4]) + (" …" if len(differ) > 4 else "")
    far = max(_far(each, other[each.name]) for each in differ)
    apart = f"at most {far:.2f} m" if far >= CLOSE else "nowhere as much as a centimetre"
    said = f"In {len(differ)} of {count} runs it sends other messages than the reference ({names})"
    return f"{said}, and the robot is {apart} from where the reference has it."


def _far(mine: Recording, theirs: Recording) -> float:
    """Return the largest distance of two robots at the same time [m]."""
    a, b = mine.truth, theirs.truth
    n = min(len(a.t), len(b.t))
    return float(np.hypot(a.x[:n] - b.x[:n], a.y[:n] - b.y[:n]).max(initial=0.0))


def _sent(recording: Recording) -> list[tuple[str, bytes]]:
    hidden = ("/rosout", "/parameter_events")
    return [(each.topic, each.data) for each in recording.published if each.topic not in hidden]


def _laps(mine: Grading, theirs: Grading) -> list[tuple[str, float, float]]:
    """Return a race's figures in all worlds that both finish, with their names."""
    contract = contract_of(mine.exercise)
    other = {each.name: lap_of(each, contract).figure for each in theirs.recordings}
    one = [(each.name, lap_of(each, contract).figure) for each in mine.recordings
           if contract.race and not each.scenario.bench]  # fmt: skip
    return [(name, lap, past) for name, lap in one if lap and (past := other[name])]


def _failed(grading: Grading) -> list[str]:
    return [each.title for each in grading.checks if each.kind == "field" and each.outcome != PASS]


def _field(grading: Grading) -> str:
    known = sum(check.kind == "field" for check in grading.checks)
    if failed := _failed(grading):
        return f"Of {known} field checks it fails {len(failed)}: {' '.join(failed)}"
    return f"It passes all {known} field checks: other sensors and networks change nothing."


def main(arguments: Sequence[str]) -> int:
    """Write a file for each exercise."""
    out = Path(arguments[0])
    out.mkdir(parents=True, exist_ok=True)
    with launcher_pool(most=1) as servers:
        for exercise in map(find_exercise, arguments[1:]) if arguments[1:] else all_exercises():
            made = json.dumps(ways_of(exercise, servers))
            (out / f"{exercise.slug}.json").write_text(made, "utf-8")
            print(f"{exercise.slug}: two ways", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
