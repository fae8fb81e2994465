"""README's two commands, as they stand there, in a fresh clone. pip asks its index."""

import re
from pathlib import Path

import pytest
from person import ROOT, Person, clone

TWO = (ROOT / "README.md").read_text("utf-8").partition("## Two commands")[2].partition("\n## ")[0]
GRADE, TEST = re.findall(r"(?m)^    (make .+)$", TWO)
(PRINTED,) = re.findall(r"(?ms)^```text\n(.+?)^```$", TWO)


@pytest.mark.long
def test_the_first(tmp_path: Path) -> None:
    folder = clone(Person(tmp_path), "course")
    assert Person(folder).types(GRADE).endswith(PRINTED)
    assert "<html" in (folder / "report.html").read_text("utf-8")


@pytest.mark.long
def test_the_second_from_the_network(tmp_path: Path) -> None:
    """All tests are collected there; run are a few."""
    person = Person(clone(Person(tmp_path), "course"))
    said = person.types(f"PYTEST_ADDOPTS='-k test_budget' {TEST}")
    assert "2 passed" in said
