"""Trouble with the machine: stalls, canaries that can't be judged, progress in spite of them."""

import io
import re
import shutil
from concurrent.futures import BrokenExecutor
from pathlib import Path
from typing import Any

import pytest
from fake_class import FILE, Drifting, Judge, but, fair, grading, until
from handing_in import put
from rich.console import Console

from grader.classroom import progress
from grader.classroom.progress import Progress
from grader.classroom.queue.store import Store
from grader.classroom.queue.work import Unit, UnitResult
from grader.classroom.row import GRADED, HELD, TWICE, WAITING

STALLED = grading("stop_zone", outcome="inconclusive")
METADATA = "submission_{}:\n  :submitters:\n  - :name: {}\n  - :name: {}\n  - :name: {}\n"


class Machine:
    """A judge whose machine stalls, so many times for each."""

    def __init__(self, **stalls: int) -> None:
        self.stalls = stalls

    def __call__(self, unit: Unit) -> UnitResult:
        name = unit.student.lstrip(".")
        if self.stalls.get(name, 0) > 0:
            self.stalls[name] -= 1
            return UnitResult(STALLED)
        return fair(unit)


# --- stalls --------------------------------------------------------------------------------


@pytest.mark.parametrize("canary", ["reference", "mutant"])
def test_a_canary_that_stalls_is_judged_again_and_nothing_else_is(
    canary: str, grade_class: Any
) -> None:
    results, workers, quiet = grade_class(Machine(**{canary: 1}), canaries=25)
    again = [unit.alone for unit in workers.seen if unit.student == f".{canary}"]
    assert again == [False, True, False]
    assert workers.students == ["ann", "bob", "eve"]
    assert {r.state for r in results.values()} == {GRADED}
    assert not [line for line in quiet.lines if "quarantine" in line or "stalled" in line]


def test_a_machine_that_always_stalls_costs_nobody_the_grading(
    grade_class: Any, tmp_path: Path
) -> None:
    results, workers, _ = grade_class(Machine(reference=99), canaries=25)
    assert workers.students == ["ann", "bob", "eve"]
    assert {r.state for r in results.values()} == {GRADED}
    said = "no known solution confirms 3 gradings"
    assert said in (tmp_path / "out" / "class.html").read_text()

    _, workers, _ = grade_class(canaries=25)  # the next run asks a canary again
    assert workers.students == []
    assert [unit.student for unit in workers.seen] == [".reference", ".mutant"]
    assert said not in (tmp_path / "out" / "class.html").read_text()
    assert grade_class(canaries=25)[1].seen == []


def test_second_judgements_that_always_stall_come_to_an_end(grade_class: Any) -> None:
    stalls = {"ann": 99, "bob": 99}
    results, workers, quiet = grade_class(Machine(**stalls))
    assert [unit.alone for unit in workers.seen] == [False, False, False, True, True]
    assert {name for name, r in results.items() if r.state == HELD} == stalls.keys()
    assert all(TWICE in results[name].problem and results[name].grading for name in stalls)
    assert len([line for line in quiet.lines if ": held" in line]) == 2

    results, workers, _ = grade_class(retry_held=True)
    assert workers.students == ["ann", "bob"]
    assert {r.state for r in results.values()} == {GRADED}


def test_a_killed_batch_remembers_what_waits_for_a_second_judgement(
    grade_class: Any, tmp_path: Path
) -> None:
    def killed(unit: Unit) -> UnitResult:
        if unit.student == "eve":
            raise KeyboardInterrupt
        return UnitResult(STALLED) if unit.student == "ann" else fair(unit)

    with pytest.raises(KeyboardInterrupt):
        grade_class(killed)
    assert grade_class(regrade=True)[1].students == ["bob"]  # ann is not done yet
    results, workers, _ = grade_class()
    assert workers.students == ["eve", "ann"]
    assert workers.seen[-1].alone
    assert results["ann"].state == GRADED


def test_the_points_of_a_stalled_one_do_not_look_like_full_marks(
    grade_class: Any, tmp_path: Path
) -> None:
    passed = grading("wiring", outcome="pass")
    passed["checks"][0]["points"] = 5
    some = {**STALLED, "score": 5, "max_score": 5}
    some["checks"] = [*passed["checks"], *STALLED["checks"]]
    grade_class(but("ann", UnitResult(some)))
    page = (tmp_path / "out" / "class.html").read_text()
    assert "5 of 10, 5 not judged" in page
    assert "read the submission first" in page


# --- trouble while a canary is judged ----------------------------------------------------------


def died(_: Unit) -> UnitResult:
    raise BrokenExecutor


def failed(_: Unit) -> UnitResult:
    return UnitResult(grading("stop_zone", outcome="error"))


def filled(_: Unit) -> UnitResult:
    return UnitResult(None, "no space", disk_full=True)


@pytest.mark.parametrize("trouble", [died, failed, filled])
@pytest.mark.parametrize("times", [1, 2])
def test_trouble_beside_a_canary_is_forgiven_but_what_lasts_is_not(
    trouble: Judge, times: int, grade_class: Any
) -> None:
    left = [""] * times

    def judge(unit: Unit) -> UnitResult:
        if unit.student == ".mutant" and left:
            left.pop()
            return trouble(unit)
        return fair(unit)

    results, workers, _ = grade_class(judge, canaries=25)
    mutants = [unit.alone for unit in workers.seen if unit.student == ".mutant"]
    assert {r.state for r in results.values()} == ({HELD} if times == 2 else {GRADED})
    assert mutants == ([False, True] if times == 2 else [False, True, False])


# --- progress ------------------------------------------------------------------------------


def test_an_interrupted_batch_says_how_far_it_writes(
    grade_class: Any, handed_in: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put(handed_in, *(f"a{number:02}/{FILE}" for number in range(19)))
    out = io.StringIO()
    monkeypatch.setattr("fake_class.Quiet", lambda: Progress(Console(file=out, width=200)))
    with pytest.raises(KeyboardInterrupt):
        grade_class(until("eve"))
    told = out.getvalue().partition("interrupted: writing what is graded")[2]
    assert "the pages of 10 of 22 students are written" in told
    assert "the pages of 20 of 22 students are written" in told


def test_a_group_has_its_result_as_soon_as_its_leader_has(
    grade_class: Any, handed_in: Path, tmp_path: Path
) -> None:
    shutil.rmtree(handed_in)
    groups = ("Al", "Cy", "Zed"), ("Bo", "Ed", "Yul"), ("Gil", "Hu", "Ian")
    told = "".join(METADATA.format(number, *group) for number, group in enumerate(groups))
    names = (f"submission_{number}/{FILE}" for number in range(3))
    put(handed_in, *names, **{"submission_metadata.yml": told})
    with pytest.raises(KeyboardInterrupt):
        grade_class(until("Gil"))
    with Store(tmp_path / "out" / "store.sqlite") as store:
        states = {each.student: each.state for each in store.results()}
    assert [[states[name] for name in group] for group in groups] == [
        [GRADED] * 3, [GRADED] * 3, [WAITING] * 3,
    ]  # fmt: skip


def test_progress_counts_each_unit_once_and_to_its_total(
    grade_class: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = io.StringIO()
    monkeypatch.setattr("fake_class.Quiet", lambda: Progress(Console(file=out, width=200)))
    _, workers, _ = grade_class(Drifting(), canaries=25)
    assert workers.students == ["ann", "bob", "eve"] * 2
    firsts = [line.split()[0] for line in out.getvalue().splitlines()]
    assert [each for each in firsts if "/" in each] == ["1/3", "2/3", "3/3", "3/3", "3/3", "3/3"]


def test_what_is_put_off_does_not_make_the_estimate_grow(monkeypatch: pytest.MonkeyPatch) -> None:
    seconds = iter(range(0, 6000, 60))
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(seconds))
    monkeypatch.setattr(progress, "EVERY", 1)
    said = io.StringIO()
    shown = Progress(Console(file=said, width=200))
    shown.begin(20)
    for number in range(20):  # a minute each
        shown.done(f"student {number}", "exercise", "will retry", over=number % 2 == 0)
    left = [int(text) for text in re.findall(r"about (\d+) min", said.getvalue())]
    assert (left[0], left[-1]) == (19, 10)
    assert left == sorted(left, reverse=True)


def test_progress_prints_whatever_a_student_wrote(capsys: pytest.CaptureFixture[str]) -> None:
    out = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    shown = Progress(Console(file=out, width=200))
    shown.begin(1)
    shown.done("Zoë\udcff", "goal_seeking", "held: \x1b[31mred\n1/1 \udcff ünsafe")
    shown.say("note: \udcff \x1b]0;title\x07")
    out.flush()
    said = out.buffer.getvalue().decode("ascii").splitlines()
    assert len(said) == 2
    assert "\x1b" not in "".join(said)


def test_a_stall_begins_no_round_of_canaries(grade_class: Any) -> None:
    _, workers, _ = grade_class(Machine(ann=1), canaries=25)
    order = [unit.student for unit in workers.seen]
    canaries = [".reference", ".mutant"]
    assert order == [*canaries, "ann", "bob", "eve", "ann", *canaries]
