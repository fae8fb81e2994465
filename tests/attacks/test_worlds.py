"""A table of the public scans is worth nothing with a secret, and no process knows its seed."""

import json
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from grader.checks.obstacle_avoidance.contract import right_speeds
from grader.course.exercises import find_exercise
from grader.course.students import host_seed, student_key
from grader.course.submission import Submission
from grader.grading.grading import grade_submission
from grader.link.hosts import ForkServer
from grader.recording import Recording
from grader.trial.trials import NodeTrials
from sim.messages import EPOCH_NS

HERE = Path(__file__).resolve().parent / "worlds"
EXERCISE = find_exercise("obstacle_avoidance")
REFERENCE = Submission(EXERCISE.solutions / EXERCISE.files[0])
KEY = student_key(b"a secret of a course", "ada", EXERCISE.slug)
BENCHES = ("avoid_zones", "avoid_infinity", "avoid_invalid", "avoid_too_close", "avoid_blind")
ONLY = ("clear_zone", "slow_zone", "stop_zone", "invalid_readings")


@pytest.fixture(scope="module")
def forkserver() -> Iterator[ForkServer]:
    with ForkServer(EPOCH_NS) as forkserver:
        yield forkserver


@pytest.fixture(scope="module")
def public(forkserver: ForkServer) -> list[Recording]:
    with NodeTrials(REFERENCE, forkserver) as trials:
        return [trials.get(name) for name in BENCHES]


def points(submission: Submission, forkserver: ForkServer, key: str | None) -> float:
    return grade_submission(
        EXERCISE, submission, forkserver, file="table.py", only=ONLY, seed=key
    ).score


@pytest.mark.parametrize(("digits", "spoilt"), [(6, 0.0), (2, 0.0), (1, 0.0)])
def test_a_table_of_scans_is_worth_nothing_with_a_secret(
    digits: int,
    spoilt: float,
    forkserver: ForkServer,
    public: list[Recording],
    tmp_path: Path,
) -> None:
    text = (HERE / "rounded_table.py").read_text().replace("DIGITS = 1", f"DIGITS = {digits}")
    node, table = tmp_path / EXERCISE.files[0], tmp_path / "table.json"
    node.write_text(text)
    rows = {
        str(zlib.crc32(np.round(scan.ranges, digits).astype(np.float32).tobytes())): min(
            right_speeds(scan)
        )
        for recording in public
        for scan in recording.scans()
    }
    table.write_text(json.dumps(rows))
    submission = Submission(node, others=(table,))

    open_worlds, own_worlds = (points(submission, forkserver, key) for key in (None, KEY))
    wiring = points(REFERENCE, forkserver, KEY)
    assert own_worlds < 0.7 * open_worlds <= wiring
    assert spoilt <= own_worlds


def test_a_nodes_process_finds_no_seed(forkserver: ForkServer) -> None:
    with NodeTrials(Submission(HERE / "looks_for_the_seed.py"), forkserver, seed=KEY) as trials:
        recording = trials.get("avoid_wall")
    said = " ".join(line.text for line in recording.log) + recording.outcome.text
    numbers = {int(word) for word in said.split() if word.isdigit()}

    assert host_seed(recording.seed) in numbers  # it has looked where the seed used to be
    secrets = {recording.seed, recording.seed % 2**63, recording.seed % 2**32}
    assert not secrets & numbers
    assert str(recording.seed) not in said
