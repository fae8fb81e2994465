"""An exercise is a place: no code outside its folders names it, by slug or number."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from grader.course.exercises import JUDGE, ROOT, all_exercises

SCOPE = (
    "grader",
    "rclpy_virtual_time",
    "sim",
    "exercises/launch",
    "exercises/setup.py",
    "pyproject.toml",
    ".ci",
)
SUFFIXES = {".py", ".toml", ".js", ".j2", ".html", ".xml", ".in", ""}
SLUGS = re.compile("|".join(exercise.slug for exercise in all_exercises()))
NUMBERS = re.compile(r"exercise\.number (==|!=|in)\b|\bnumber (==|!=) \d")


def sources() -> Iterator[Path]:
    for place in SCOPE:
        path = ROOT / place
        found = path.rglob("*") if path.is_dir() else [path]
        for file in found:
            if file.is_file() and file.suffix in SUFFIXES and not file.is_relative_to(JUDGE):
                yield file


@pytest.mark.parametrize("pattern", [SLUGS, NUMBERS], ids=["slug", "number"])
def test_no_code_names_an_exercise(pattern: re.Pattern[str]) -> None:
    named = [
        f"{file.relative_to(ROOT)}:{number}: {line.strip()}"
        for file in sources()
        for number, line in enumerate(file.read_text("utf-8", "replace").splitlines(), 1)
        if pattern.search(line)
    ]
    assert named == []
