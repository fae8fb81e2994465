"""Generated files: written if they differ, named by --check, and nothing on wrong usage."""

from pathlib import Path

import pytest

from grader.course.generated import CHECK, write_or_check
from grader.errors import InputError


def test_what_differs_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    same, stale, new = (tmp_path / name for name in ("same", "stale", "folder/new"))
    same.write_text("text")
    stale.write_text("old")
    files = [(path, "text") for path in (same, stale, new)]

    assert write_or_check(files, "make them") == 0
    assert {path.read_text() for path in (same, stale, new)} == {"text"}
    assert capsys.readouterr().out == "wrote stale\nwrote new\n"
    assert write_or_check(files, "make them", [CHECK]) == 0


def test_check_names_the_files_and_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stale = tmp_path / "stale"
    stale.write_text("old")

    assert write_or_check([(stale, "new")], "make them", [CHECK]) == 1
    assert stale.read_text() == "old"
    assert capsys.readouterr().out == "stale is out of step: run `make them`\n"


@pytest.mark.parametrize("arguments", [["--chekc"], [CHECK, CHECK], ["out"]])
def test_wrong_usage_writes_nothing(tmp_path: Path, arguments: list[str]) -> None:
    assert write_or_check([(tmp_path / "new", "text")], "make them", arguments) == 2
    assert not (tmp_path / "new").exists()


def test_a_wrong_source_is_a_message(capsys: pytest.CaptureFixture[str]) -> None:
    def files():  # type: ignore[no-untyped-def]
        raise InputError("solution.py, line 3: no END SOLUTION")
        yield

    assert write_or_check(files(), "make them") == 2
    assert "line 3" in capsys.readouterr().err
