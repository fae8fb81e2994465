"""Every solution, right or wrong, gets what it says it deserves.

`make prove` takes all solutions. The tests take all references, and mutants enough for every check
to have failed one. `make test` has the core of references that are soon driven, and mutants for
checks that cap a score; `make test-proof`, which CI runs, too, has the rest.
"""

import contextlib
import importlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest

from grader.authoring import proof
from grader.authoring.proof import Row, keep, main, objections, unproven
from grader.checks.case import Runs
from grader.checks.verdict import CheckFailed, Inconclusive
from grader.claims.claims import Claim, claim_of, claims, complete, cover, grade_claim
from grader.course.exercises import Exercise, all_exercises
from grader.errors import GraderError
from grader.exercises import oracle_of
from grader.grading.grading import Grading, grade
from grader.grading.plugin import UNAVAILABLE, CheckResult
from grader.launchers import ForkServerPool
from grader.trial.kept import KeptRecordings
from grader.trial.trials import NodeTrials, SavedTrials, _trainings
from rclpy_virtual_time.host.frames import Note
from sim.scenario_files import load_scenario

CLAIMS = {exercise.slug: list(claims(exercise)) for exercise in all_exercises()}
RIGHT = [claim for every in CLAIMS.values() for claim in every if claim.kind == "reference"]
RIGHT += [claim for claim in CLAIMS["obstacle_avoidance"] if claim.kind in ("skeleton", "variant")]
DEAR = {"heavy_callback", "searches_its_history"}  # ten times the CPU of others
WRONG = [each for exercise in all_exercises() for each in cover(exercise, without=DEAR)]
WRONG_IN_THE_FIELD = [each for exercise in all_exercises() for each in cover(exercise, field=True)]
LONG = pytest.mark.long
LONG_DRIVES = {"ml_velocity", "goal_seeking", "slow_model", "safety_supervisor", "model_formats"}


def soon(claim: Claim, checks: frozenset[str]) -> bool:
    """Return whether a check caps a score, and the mutant that fails it costs little."""
    essential = claim.exercise.essential
    caps = bool(essential and checks.intersection(essential.checks))
    return caps and claim.exercise.slug not in LONG_DRIVES


def soon_driven(claim: Claim) -> bool:
    """Return whether a claim is a reference: not of the five that cost more than half of all."""
    return claim.kind == "reference" and claim.exercise.slug not in LONG_DRIVES


@pytest.mark.parametrize("field", [False, pytest.param(True, marks=LONG)])
@pytest.mark.parametrize(
    "claim",
    [
        pytest.param(claim, id=claim.name, marks=() if soon_driven(claim) else LONG)
        for claim in RIGHT
    ],
)
def test_claims_hold(
    claim: Claim, forkservers: ForkServerPool, recordings: KeptRecordings, *, field: bool
) -> None:
    servers = forkservers.of(claim.exercise.libraries)
    grading = grade_claim(claim, servers, field=field, kept=recordings)
    assert objections(claim, grading) == []
    if lacking := unproven(claim, grading):
        pytest.skip(f"proven but for {lacking}: a library is not installed (make test-deep)")


@pytest.mark.parametrize(
    ("claim", "checks"),
    [
        pytest.param(claim, checks, id=claim.name, marks=() if soon(claim, checks) else LONG)
        for claim, checks in (*WRONG, *WRONG_IN_THE_FIELD)
    ],
)
def test_each_check_fails_a_wrong_solution(
    claim: Claim, checks: frozenset[str], forkservers: ForkServerPool, recordings: KeptRecordings
) -> None:
    """Of its runs are judged those that show the mistake.

    One run after the other takes the place of the reference's, the shortest first: what shows the
    mistake in one scenario needs no trials in ten.
    """
    servers = forkservers.of(claim.exercise.libraries)
    right = next(each for each in RIGHT if each.exercise == claim.exercise)
    with (
        complete(claim) as mine, NodeTrials(mine, servers, kept=recordings) as wrong_trials,
        complete(right) as theirs, NodeTrials(theirs, servers, kept=recordings) as right_trials,
    ):  # fmt: skip
        passed = [
            name
            for name in sorted(checks)
            if not fails(claim.exercise, check_of(claim.exercise, name), wrong_trials, right_trials)
        ]
    assert not passed


def check_of(exercise: Exercise, name: str) -> Callable[[Runs], None]:
    for file in sorted(exercise.judge.glob("test_*.py")):
        module = importlib.import_module(f"grader.exercises.{exercise.slug}.{file.stem}")
        if check := getattr(module, f"test_{name}", None):
            return check  # type: ignore[no-any-return]
    raise AssertionError(f"{exercise.slug} has no check {name}")


def fails(
    exercise: Exercise, check: Callable[[Runs], None], wrong: NodeTrials, right: NodeTrials
) -> bool:
    """Return whether a check fails on runs of a wrong solution, or can't be judged here."""
    (mark,) = (mark.kwargs for mark in check.pytestmark if mark.name == "check")  # type: ignore[attr-defined]
    names = mark["scenarios"]
    if wrong.lacks(names, mark.get("requires", ())):
        return True
    scenarios = {name: load_scenario(name) for name in names}
    order = sorted(names, key=lambda name: scenarios[name].duration)
    alone = not any(map(_trainings, scenarios.values()))  # or a model is another's than its node
    for count in range(1 if alone else len(order), len(order) + 1):
        own = {name: wrong.get(name) for name in order[:count]}
        runs = [own.get(name) or right.get(name) for name in names]
        with contextlib.suppress(Inconclusive):
            try:
                check(Runs(runs, oracle_of(exercise), exercise.slug))
            except CheckFailed:
                return not any(each.live and each.live.stall for each in own.values())
    return False


@pytest.mark.parametrize("exercise", all_exercises(), ids=lambda exercise: exercise.slug)
def test_these_wrong_solutions_fail_every_check(exercise: Exercise) -> None:
    graded = grade(exercise, SavedTrials([]), file="x.py", field=True).checks
    for field, wrong in ((False, WRONG), (True, WRONG_IN_THE_FIELD)):
        covered = set().union(*(checks for each, checks in wrong if each.exercise == exercise))
        checks = {check.id for check in graded if (check.kind == "field") is field}
        lacking = {check.id for check in graded if check.outcome == UNAVAILABLE}
        wanted = f"{exercise.solutions / 'mutants.diff'}: a mutant with it in `fails`"
        assert checks - lacking - covered == set(), wanted


@pytest.mark.parametrize("exercise", all_exercises(), ids=lambda exercise: exercise.slug)
def test_there_are_solutions_of_every_kind(exercise: Exercise) -> None:
    kinds = {claim.kind for claim in CLAIMS[exercise.slug]}
    assert {"reference", "skeleton", "variant", "mutant"} - kinds == set(), exercise.solutions


CATALOGUE = """
base: server.py

mutant answers_wrong fails answers
Answers wrong.
requires: torch
-ANSWER = 1
+ANSWER = 2

mutant asks_wrong fails asks
Asks wrong.
base: variants/shy.py
-ASK = "please"
+ASK = "now"
"""
TEXTS = {
    "server.py": '"""The server."""\n\nANSWER = 1\n',
    "client.py": '"""The client."""\n\nASK = 1\n',
    "variants/both/server.py": '"""A folder.\n\nfield: all\n"""',
    "variants/both/client.py": "variant",
    "variants/shy.py": '"""Shy.\n\nfile: client.py\n"""\n\nASK = "please"\n',
    "mutants.diff": CATALOGUE,
}
SHOULD_FAIL = "should fail answers, and does not"


@pytest.fixture
def pair(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Exercise:
    """An exercise of two files, with solutions in a folder of its own."""
    monkeypatch.setattr("grader.course.exercises.SOLUTIONS", tmp_path / "solutions")
    monkeypatch.setattr("grader.course.exercises.JUDGE", tmp_path / "checks")
    exercise = Exercise(99, "pair", "Pair", "", ("server.py", "client.py"), "server", 100)
    checks = "def test_answers():\n    pass\n\n\ndef test_asks():\n    pass\n"
    files = {exercise.solutions / name: text for name, text in TEXTS.items()}
    for path, text in {**files, exercise.judge / "test_core.py": checks}.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return exercise


def named(exercise: Exercise, stem: str) -> Claim:
    """Return the one claim of that name."""
    (claim,) = (claim for claim in claims(exercise) if claim.stem == stem)
    return claim


def graded(claim: Claim, **outcomes: str) -> Grading:
    """Return a grading of checks of 50 points each."""
    checks = [
        CheckResult(name, name, "core", 50 * (outcome == "pass"), 50, outcome)
        for name, outcome in outcomes.items()
    ]
    return Grading(claim.exercise, "x.py", 1, tuple(checks), ())


@pytest.mark.parametrize(
    ("kind", "fails", "answers", "asks", "against", "lacking"),
    [
        ("reference", "", "pass", "pass", [], ""),
        ("reference", "", "pass", "unavailable", [], "50 points"),
        ("reference", "", "pass", "fail", ["gets 50 of 100: fails {'asks'}"], ""),
        ("mutant", "answers asks", "fail", "unavailable", [], "asks"),
        ("mutant", "answers asks", "pass", "unavailable", [SHOULD_FAIL], "asks"),
        ("mutant", "answers", "fail", "fail", [], ""),  # it may fail more than it names
        ("mutant", "answers", "pass", "fail", [SHOULD_FAIL], ""),
    ],
)
def test_what_is_against_a_claim_and_what_a_missing_library_leaves_unproven(
    kind: str, fails: str, answers: str, asks: str, against: list[str], lacking: str, pair: Exercise
) -> None:
    ready = kind == "reference"
    claim = Claim(pair, kind, "a", {}, field_ready=ready, fails=frozenset(fails.split()))
    grading = graded(claim, answers=answers, asks=asks)
    assert objections(claim, grading) == against
    assert unproven(claim, grading) == lacking


def test_a_reference_is_told_nothing(pair: Exercise) -> None:
    reference = Claim(pair, "reference", "server", {})
    grading = graded(reference, answers="pass", asks="pass")
    told: Any = SimpleNamespace(
        name="plain", notes=[Note("waits", "ask", "server.py, line 3", time=10**9)],
        ending=SimpleNamespace(problem="it goes on"), inferences=(),
        scenario=load_scenario("avoid_wall"),
    )  # fmt: skip
    grading = replace(grading, recordings=(told,))
    noted, ends = objections(reference, grading)
    assert noted.startswith("is told: in plain, ask (server.py, line 3) waits there")
    assert ends == "after Ctrl-C it goes on"
    assert objections(Claim(pair, "variant", "server", {}), grading) == []


@pytest.mark.parametrize("second", ["fail", "pass", "inconclusive"])
def test_what_a_stall_left_open_is_judged_again_alone(
    second: str, pair: Exercise, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    mutant = Claim(pair, "mutant", "a", {}, fails=frozenset({"asks"}))
    first = graded(mutant, answers="pass", asks="inconclusive")
    tally = proof._prove(pair, [mutant], iter([first]))
    assert tally.stalled == [mutant]
    assert tally.objections

    asked = []

    def again(claims: list[Claim], workers: int, kept: KeptRecordings) -> Iterator[Grading]:
        asked.append((claims, workers))
        yield graded(mutant, answers="pass", asks=second)

    monkeypatch.setattr(proof, "gradings", again)
    proof._prove_stalled(tally, KeptRecordings(tmp_path / "kept"))
    assert asked == [([mutant], 1)]
    assert bool(tally.uncaught) == (second != "fail")
    assert ("pair: asks" in tally.unneeded) == (second == "pass") or second == "inconclusive"


def test_a_mutant_may_need_a_library(pair: Exercise, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    mutant = named(pair, "answers_wrong")
    assert mutant.fails == {"answers"}
    assert "PyTorch is not installed" in mutant.lacks


def test_one_file_of_two_is_graded_with_the_reference_of_the_other(pair: Exercise) -> None:
    for stem, file, wrong in (
        ("answers_wrong", "server.py", "ANSWER = 2"),
        ("asks_wrong", "client.py", 'ASK = "now"'),
    ):
        with complete(named(pair, stem)) as submission:
            texts = {path.name: path.read_text() for path in (submission.path, *submission.others)}
        assert wrong in texts.pop(file)
        (other,) = texts
        assert texts[other] == TEXTS[other]


def test_a_variant_may_be_a_folder(pair: Exercise) -> None:
    variant = named(pair, "both")
    assert variant.field_ready
    assert variant.about == "A folder."
    with complete(variant) as submission:
        assert "A folder" in submission.path.read_text()
        assert [path.read_text() for path in submission.others] == ["variant"]


def test_a_variant_may_be_one_file_of_several(pair: Exercise) -> None:
    variant = named(pair, "shy")
    assert not variant.field_ready
    assert variant.files == {"server.py": TEXTS["server.py"], "client.py": TEXTS["variants/shy.py"]}


def test_a_file_that_stands_for_none(pair: Exercise) -> None:
    path = pair.solutions / "variants" / "wrong.py"
    path.write_text('"""Wrong.\n\nfile: clients.py\n"""')
    with pytest.raises(GraderError, match=r"stands for clients\.py; expected one of server\.py"):
        claim_of(pair, "variant", path)


@pytest.mark.long
def test_one_mutant_can_be_proven_alone(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["obstacle_avoidance", "--only", "wrong_topic"]) == 0
    assert (
        capsys.readouterr().out == "obstacle_avoidance/mutant/wrong_topic: 0 points; fails wiring\n"
    )


@pytest.mark.parametrize(
    ("arguments", "said"),
    [(["nope"], "unknown exercise 'nope'"), (["1", "--only", "nope"], "is called 'nope'")],
)
def test_what_can_not_be_proven_is_said_in_a_line(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2
    assert said in capsys.readouterr().err


def test_an_edit_that_does_not_fit_is_said_in_a_line(
    pair: Exercise, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(proof, "find_exercise", lambda name: pair)
    (pair.solutions / "server.py").write_text('"""The server."""\n\nANSWER = 3\n')
    with pytest.raises(SystemExit) as ended:
        main(["pair"])
    assert ended.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "mutant.answers_wrong: hunk '-ANSWER = 1' fits 0 times in server.py" in line


def test_claims_are_kept_one_a_line(pair: Exercise, tmp_path: Path) -> None:
    file = tmp_path / "build" / "proof.jsonl"
    rows = [
        Row.of(
            "mutant", name, "Asks wrong.", graded(named(pair, name), answers="pass", asks="fail")
        )
        for name in ("asks_wrong", "shy")
    ]
    keep(file, rows)
    lines = file.read_bytes().splitlines()
    assert [msgspec.json.decode(line, type=Row) for line in lines] == rows
    assert (rows[0].points, rows[0].most, rows[0].fails) == (50, 100, ("asks",))
