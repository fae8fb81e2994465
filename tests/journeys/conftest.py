"""What several journeys begin with. Each starts where its person starts."""

from pathlib import Path

import pytest
from person import MadeOnce, Person, clone, environment


@pytest.fixture(scope="session")
def installed(made_once: MadeOnce, wheel: Path) -> Path:
    """Return an empty environment into which the wheel was installed."""
    return made_once("installed", lambda folder: environment(folder / "env", str(wheel))) / "env"


@pytest.fixture
def person(tmp_path: Path, installed: Path) -> Person:
    """Return somebody with the wheel and an empty folder."""
    return Person(tmp_path, installed)


@pytest.fixture(scope="session")
def instructors(made_once: MadeOnce) -> Path:
    """Return an instructor's folder of notebooks, in a clone; beside that is an environment."""

    def make(folder: Path) -> None:
        course = clone(Person(folder), "course")
        env = environment(folder / "env", f"--editable {course}", ("ros", "notebooks"))
        instructor = Person(course / "notebooks", env)
        for line in ("python -m grader.notebook.build", "nbgrader generate_assignment 01_loop"):
            instructor.types(line)

    return made_once("instructors", make) / "course" / "notebooks"
