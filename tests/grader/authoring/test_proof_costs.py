"""What the proof says about the price of a mistake."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from grader.authoring.costs import Row, keep, print_costs


def a_row(name: str, lost: int, cause: str = "", kind: str = "mutant") -> Row:
    fails = ("stop_zone",) if kind == "mutant" else ()
    return Row("goal_seeking", kind, name, "Turns the wrong way.", 100 - lost, 100, fails, cause)


ROWS = [
    a_row("reference", 0, kind="reference"),
    a_row("skeleton", 100, kind="skeleton"),
    a_row("small", 10, "It turns the wrong way."),
    a_row("middle", 20, "It turns right where it should turn left."),
    a_row("large", 65),
    a_row("field_only", 0),
]


def test_table_has_median_and_worst(capsys: pytest.CaptureFixture[str]) -> None:
    print_costs(ROWS)
    line = capsys.readouterr().out.splitlines()[-1]
    assert line.split() == ["goal_seeking", "20", "65", "large"]


def test_exercise_whose_mutants_lose_nothing_has_no_median(
    capsys: pytest.CaptureFixture[str],
) -> None:
    print_costs([a_row("field_only", 0)])
    assert capsys.readouterr().out.splitlines()[-1].split() == ["goal_seeking", "-", "0"]


def test_rows_are_kept_one_a_line(tmp_path: Path) -> None:
    file = tmp_path / "build" / "proof.jsonl"
    keep(file, ROWS)
    lines = file.read_bytes().splitlines()
    assert [msgspec.json.decode(line, type=Row) for line in lines] == ROWS
