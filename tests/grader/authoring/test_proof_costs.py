"""What the proof says about the price of a mistake, and what its author is told."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from grader.authoring.costs import Row, keep, print_costs, silences


def a_row(name: str, lost: int, cause: str = "", kind: str = "mutant") -> Row:
    fails = ("stop_zone",) if kind == "mutant" else ()
    return Row("goal_seeking", kind, name, "Turns the wrong way.", 100 - lost, 100, fails, cause)


ROWS = [
    a_row("reference", 0, kind="reference"),
    a_row("skeleton", 100, kind="skeleton"),
    a_row("small", 10, "Most probably: the node turns the wrong way."),
    a_row("middle", 20, "It turns right where it should turn left."),
    a_row("large", 65),
    a_row("field_only", 0),
]


def test_table_has_median_worst_and_how_many_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    print_costs(ROWS)
    line = capsys.readouterr().out.splitlines()[-1]
    assert line.split() == ["goal_seeking", "20", "65", "1", "1", "2", "large"]


def test_exercise_whose_mutants_lose_nothing_has_no_median(
    capsys: pytest.CaptureFixture[str],
) -> None:
    print_costs([a_row("field_only", 0)])
    assert capsys.readouterr().out.splitlines()[-1].split() == ["goal_seeking", "-", "0", *"001"]


def test_rows_are_kept_one_a_line(tmp_path: Path) -> None:
    file = tmp_path / "build" / "proof.jsonl"
    keep(file, ROWS)
    lines = file.read_bytes().splitlines()
    assert [msgspec.json.decode(line, type=Row) for line in lines] == ROWS


def test_stale_catalogue_is_an_objection() -> None:
    told, silent = a_row("told", 10, "It turns right."), a_row("silent", 10)
    (objection,) = silences([told, silent, silent])
    assert objection.startswith("goal_seeking: 1 of 3 mutants are told a cause, fewer than 70%")
    assert "grader.authoring.causes goal_seeking" in objection
    assert silences([told, told, told, silent]) == []


def test_exercise_without_a_catalogue_owes_no_causes() -> None:
    row = Row("a_new_one", "mutant", "silent", "Is wrong.", 90, 100, ("wiring",), "")
    assert silences([row]) == []
