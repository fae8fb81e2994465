"""A student with the package that the class was given: from its README to `course next`."""

import re
from pathlib import Path

import pytest
from person import INSTRUCTOR, ROOT, MadeOnce, Person, environment

FILE = "obstacle_avoidance/obstacle_avoidance_agent.py"


@pytest.fixture(scope="session")
def package(made_once: MadeOnce) -> Path:
    """Return the archive, as an instructor makes it."""
    line = "course release course --student-package --plain"
    made = made_once("student-package", lambda folder: Person(folder, INSTRUCTOR).types(line))
    return made / "course.zip"


@pytest.mark.parametrize("pip", [pytest.param("from the network", marks=pytest.mark.long), ""])
def test_from_start_to_next(package: Path, tmp_path: Path, pip: str) -> None:
    Person(tmp_path).types(f"unzip -q {package}")
    student = Person(tmp_path / "course")
    readme = (student.home / "README.md").read_text("utf-8")
    setup, start, grade = re.findall(r"(?m)^    (.+)$", readme)[:3]  # for macOS and Linux
    if pip:
        assert f"Next: {start.rpartition(' ')[0]}\n" in student.types(setup)
    else:
        environment(student.home / ".venv", f"--editable {student.home}")
    assert grade in student.types(start)
    said = student.types(grade, code=1)
    assert "Score  0 / 100" in said and "There is no subscription on /scan." in said

    student = Person(student.home, student.home / ".venv")  # source .venv/bin/activate
    student.types(f"pytest --quiet {FILE.partition('/')[0]}", code=1)
    student.writes({FILE: (ROOT / "solutions" / FILE).read_text("utf-8")})
    assert "2 passed" in student.types(f"pytest --quiet {FILE.partition('/')[0]}")
    said = student.types(grade.removeprefix(".venv/bin/"))
    assert "Score  100 / 100" in said and "Change +100" in said
    assert "course start 2" in student.types("course next")
    assert "ml_velocity/README.md" in student.types("course start")
    assert "autograde" not in student.types("course --help")
