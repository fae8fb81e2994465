"""Seeds of students: reproducible with the secret, unpredictable without, never confused."""

from pathlib import Path

import pytest

from grader.course.students import read_secret, student_seed
from grader.errors import InputError

SECRET = b"0123456789abcdef"


def test_a_seed_depends_on_secret_student_and_exercise() -> None:
    own = student_seed(SECRET, "ada", "goal_seeking")

    assert own == student_seed(SECRET, "ada", "goal_seeking")
    others = {
        student_seed(SECRET + b"!", "ada", "goal_seeking"),
        student_seed(SECRET, "bob", "goal_seeking"),
        student_seed(SECRET, "ada", "obstacle_avoidance"),
        student_seed(SECRET, "adag", "oal_seeking"),
    }
    assert own not in others
    assert len(others) == 4


def test_seeds_are_spread() -> None:
    seeds = {student_seed(SECRET, f"student {i}", "x") for i in range(1000)}

    assert len(seeds) > 990
    assert all(0 <= seed < 10**6 for seed in seeds)


def test_a_secret_comes_from_a_file_that_is_long_enough(tmp_path: Path) -> None:
    file = tmp_path / "secret"
    file.write_bytes(SECRET + b"\n")
    assert read_secret(file) == SECRET

    file.write_bytes(b"short\n")
    with pytest.raises(InputError, match="5 bytes, expected at least 16"):
        read_secret(file)
    with pytest.raises(InputError, match="cannot read the course's secret"):
        read_secret(tmp_path / "missing")
