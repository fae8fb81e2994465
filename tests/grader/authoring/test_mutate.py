"""Mutants made by machine: that they are programs, that verdicts are kept, that gaps are told."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from grader.authoring.claims import Claim, claims
from grader.authoring.mutate import __main__ as mutate
from grader.authoring.mutate.equivalents import Equivalent, Reviewed, reviewed
from grader.authoring.mutate.singles import edits, singles
from grader.authoring.mutate.wrappers import every, wrapped, wrappers
from grader.course.exercises import all_exercises, find_exercise
from grader.errors import InputError
from grader.grading.plugin import FAIL, PASS, UNAVAILABLE

SUPERVISOR = find_exercise("safety_supervisor")
REFERENCE = next(iter(claims(SUPERVISOR)))
PROGRAM = '''"""A node."""

LIMIT = 0.5  # "½" before this: columns count bytes


class Agent:
    def step(self, d, seen):
        self.count = self.count + 1
        if d < LIMIT and not seen:
            return "½ ä" if d <= 2 else None
        self.log(f"{d + 1}")


def main():
    Agent().step(1, 2)


if __name__ == "__main__":
    main()
'''


def test_an_edit_changes_one_place_and_leaves_a_program() -> None:
    found = list(edits("agent.py", PROGRAM))
    assert len({edit.name for edit in found}) == len(found)
    for edit in found:
        ast.parse(edit.text)
        changed = [
            (old, new)
            for old, new in zip(PROGRAM.splitlines(), edit.text.splitlines(), strict=True)
            if old != new
        ]
        assert len(changed) == 1, edit.name
    names = {edit.name for edit in found}
    assert "edit step: d < LIMIT → d <= LIMIT" in names
    assert "edit step: d < LIMIT and not seen → (d < LIMIT)" in names
    assert "edit step: self.count = self.count + 1 → pass" in names
    assert "edit module: 0.5 → 1.0" in names
    assert not [name for name in names if name.startswith("edit main")]


def test_same_edits_have_numbers() -> None:
    text = "def f(a):\n    return a < 1 or a < 1\n"
    names = [edit.name for edit in edits("f.py", text) if "→ a <= 1" in edit.name]
    assert names == ["edit f: a < 1 → a <= 1", "edit f: a < 1 → a <= 1 (2)"]


def test_every_mutant_has_a_name_of_its_own() -> None:
    two_files = next(iter(claims(find_exercise("model_server"))))
    for made in ([*singles(two_files), *every(two_files)], list(every(REFERENCE))):
        assert [n for n, times in Counter(claim.stem for claim in made).items() if times > 1] == []
        assert len(made) > 150


def test_what_a_wrapper_adds_is_python() -> None:
    by_operator = {(w.operator, w.hears): w for e in all_exercises() for w in wrappers(e)}
    for wrapper in by_operator.values():
        ast.parse(wrapper.source)


def test_a_wrapper_comes_before_the_program_starts() -> None:
    wrapper = next(w for w in wrappers(SUPERVISOR) if w.name == "hears /e_stop Expires 1")
    text = wrapped(REFERENCE, wrapper).files["safety_supervisor.py"]
    hook, start = (
        text.index("hears(rclpy.node.Node, '/e_stop', Operator(1.0, expires))"),
        text.index("\nif __"),
    )
    assert text.index("class SafetySupervisor") < hook < start
    assert "def late" not in text


def test_a_program_without_a_start_cannot_be_wrapped() -> None:
    bare = replace(REFERENCE, files={"safety_supervisor.py": "print()\n"})
    with pytest.raises(ValueError, match=r"safety_supervisor\.py has no `if __name__"):
        wrapped(bare, next(wrappers(SUPERVISOR)))


# --- verdicts -------------------------------------------------------------------------------------


@pytest.fixture
def graded(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Let every mutant with "killed" in its name fail a check; return the names graded."""
    names: list[str] = []

    def gradings(
        every: Sequence[Claim], workers: int, *, first_failure: bool, suspects: Sequence[str]
    ) -> Iterator[Any]:
        assert first_failure
        for claim, suspect in zip(every, suspects, strict=True):
            names.append(f"{claim.stem} ({suspect})" if suspect else claim.stem)
            lives = UNAVAILABLE if "unsure" in claim.stem else PASS
            outcome = FAIL if "killed" in claim.stem else lives
            yield SimpleNamespace(checks=[SimpleNamespace(id="e_stop", outcome=outcome)])

    monkeypatch.setattr(mutate, "gradings", gradings)
    return names


def mutant(name: str, text: str = "x = 1\n") -> Claim:
    return replace(REFERENCE, kind="mutant", stem=name, files={"safety_supervisor.py": text})


def test_verdicts_are_kept_until_the_program_changes(tmp_path: Path, graded: list[str]) -> None:
    keep = tmp_path / "verdicts.jsonl"
    two = [mutant("one killed", "x = 1\n"), mutant("one lives", "x = 2\n")]
    first = list(mutate.judge(two, keep, 1))
    assert [verdict.killed_by for verdict in first] == ["e_stop", ""]
    keep.write_bytes(keep.read_bytes() + b'{"exercise": "safe')  # cut off while it was written
    again = list(mutate.judge([*two, mutant("one lives", "x = 3\n")], keep, 1))
    assert graded == ["one killed", "one lives", "one lives"]
    assert again[:2] == first


def test_a_survivor_that_was_not_judged_in_full_is_judged_again(
    tmp_path: Path, graded: list[str]
) -> None:
    for _ in range(2):
        (verdict,) = mutate.judge([mutant("unsure")], tmp_path / "kept", 1)
        assert verdict.unsure and not verdict.killed_by
    assert graded == ["unsure", "unsure"]


def test_what_killed_a_change_is_suspected_in_other_nodes(
    tmp_path: Path, graded: list[str]
) -> None:
    names = ("one killed", "one lives", "two lives", "two killed")
    verdicts = list(mutate.judge([mutant(name, name) for name in names], tmp_path / "kept", 1))
    assert graded == ["one killed", "one lives", "two lives", "two killed (e_stop)"]
    assert [verdict.killed_by for verdict in verdicts] == ["e_stop", "", "", "e_stop"]


def test_survivors_are_equivalent_or_gaps(
    tmp_path: Path, graded: list[str], monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    reason = "As good as right, within the contract's tolerance."
    list_ = Reviewed((Equivalent(("lives * [x]", "killed*", "nobody"), reason),))
    monkeypatch.setattr(mutate, "reviewed", lambda exercise: list_)
    names = ("killed 1", "lives 1 [x]", "lives 2")
    three = [mutant(name, name) for name in names]
    bad = mutate.summarise(SUPERVISOR, mutate.judge(three, tmp_path / "kept", 1), whole=True)
    assert bad == [
        "safety_supervisor: lives 2: survives",
        "safety_supervisor: equivalents.toml: 'killed*' matches no survivor",
        "safety_supervisor: equivalents.toml: 'nobody' matches no survivor",
    ]
    words = ["safety_supervisor", "3", "1", "1", "1", "0", "s"]
    assert capsys.readouterr().out.split() == words


def test_lists_of_equivalents_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(type(SUPERVISOR), "solutions", property(lambda self: tmp_path))
    assert reviewed(SUPERVISOR).reason("anything") == ""
    (tmp_path / "equivalents.toml").write_text('[[equivalent]]\nmutants = ["a*"]\nreason = "x"\n')
    with pytest.raises(InputError, match=r"equivalents.toml: equivalent\[0\].reason"):
        reviewed(SUPERVISOR)


def test_listing_grades_nothing(graded: list[str], capsys: Any) -> None:
    assert mutate.main(["7", "--variants", "0", "--only", "/e_stop Expires", "--list"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 7
    assert graded == []
