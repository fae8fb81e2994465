"""Seeds of students: reproducible with the secret, unpredictable without, never confused."""

from itertools import pairwise
from pathlib import Path

import pytest

from grader.course.students import (
    SECRET_SEEDS,
    host_seed,
    public_seed,
    read_secret,
    secret_seed,
    student_key,
)
from grader.errors import InputError

SECRET = b"0123456789abcdef"


def test_a_seed_depends_on_secret_student_and_exercise() -> None:
    own = student_key(SECRET, "ada", "goal_seeking")

    assert own == student_key(SECRET, "ada", "goal_seeking")
    others = {
        student_key(SECRET + b"!", "ada", "goal_seeking"),
        student_key(SECRET, "bob", "goal_seeking"),
        student_key(SECRET, "ada", "obstacle_avoidance"),
        student_key(SECRET, "adag", "oal_seeking"),
    }
    assert own not in others
    assert len(others) == 4


def test_no_scenarios_seed_tells_anothers() -> None:
    key = student_key(SECRET, "ada", "obstacle_avoidance")
    scenarios = [f"scenario_{i}" for i in range(200)]
    seeds = [secret_seed(key, name, n) for name in scenarios for n in range(5)]

    assert len(set(seeds)) == 1000
    assert secret_seed(key, "scenario_0") == seeds[0]
    assert all(SECRET_SEEDS <= seed < 2**64 for seed in seeds)
    steps = {after - before for before, after in pairwise(seeds)}
    assert len(steps) == 999  # no pattern such as "one apart"


def test_a_students_seed_is_shown_to_nobody_and_a_host_gets_a_hash() -> None:
    seed = secret_seed(student_key(SECRET, "ada", "x"), "avoid_zones")

    assert public_seed(seed) is None
    assert public_seed(1_000_004) == 1_000_004
    assert host_seed(seed) not in (seed, seed % 2**32)
    assert host_seed(seed) == host_seed(seed) != host_seed(seed + 1)


def test_a_secret_comes_from_a_file_that_is_long_enough(tmp_path: Path) -> None:
    file = tmp_path / "secret"
    file.write_bytes(SECRET + b"\n")
    assert read_secret(file) == SECRET

    file.write_bytes(b"short\n")
    with pytest.raises(InputError, match="5 bytes, expected at least 16"):
        read_secret(file)
    with pytest.raises(InputError, match="cannot read the course's secret"):
        read_secret(tmp_path / "missing")
