"""With a secret no table of the public worlds helps, and no process knows which world it is in."""

import json
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from grader.course.exercises import find_exercise
from grader.course.students import student_key
from grader.course.submission import Submission
from grader.exercises.obstacle_avoidance.contract import right_speeds
from grader.grading.grading import grade_submission
from grader.recording import Recording
from grader.trial.trials import NodeTrials
from rclpy_virtual_time.link.hosts import ForkServer

KIT = Path(__file__).resolve().with_name("kit.py")
WORLDS = KIT.parent / "worlds" / "worlds.py"
EXERCISE = find_exercise("obstacle_avoidance")
REFERENCE = Submission(EXERCISE.solutions / EXERCISE.files[0])
SECRET = b"a secret of a course"
KEY = student_key(SECRET, "ada", EXERCISE.slug)
BENCHES = ("avoid_zones", "avoid_infinity", "avoid_invalid", "avoid_too_close", "avoid_blind")
SCENARIO, NOISY = "avoid_wall", "avoid_field_speckle"
BENCH = (
    "clear_zone", "slow_zone", "stop_zone", "sees_sides", "infinite_readings", "invalid_readings",
)  # fmt: skip
ONLY = ("clear_zone", "slow_zone", "stop_zone", "invalid_readings")


@pytest.fixture(scope="module")
def public(forkserver: ForkServer) -> list[Recording]:
    with NodeTrials(REFERENCE, forkserver) as trials:
        return [trials.get(name) for name in BENCHES]


def points(
    submission: Submission, forkserver: ForkServer, key: str | None, only: Sequence[str] = ONLY
) -> float:
    return grade_submission(
        EXERCISE, submission, forkserver, file="table.py", only=only, seed=key
    ).raw_score


@pytest.mark.parametrize(
    "digits", [6, *(pytest.param(digits, marks=pytest.mark.long) for digits in (2, 1))]
)
def test_a_table_of_scans_is_worth_nothing_with_a_secret(
    digits: int, forkserver: ForkServer, public: list[Recording], tmp_path: Path
) -> None:
    rows = {
        str(zlib.crc32(np.round(scan.ranges, digits).astype(np.float32).tobytes())): min(
            right_speeds(scan)
        )
        for recording in public
        for scan in recording.scans()
    }
    changed = ("DIGITS = 1", f"DIGITS = {digits}")
    submission = handed_in(tmp_path, "rounded_table", rows, changed)

    open_worlds, own_worlds = (points(submission, forkserver, key) for key in (None, KEY))
    wiring = points(REFERENCE, forkserver, KEY)
    assert own_worlds < 0.7 * open_worlds <= wiring


def examples(recordings: list[Recording]) -> list[dict[str, list[object]]]:
    """Return each bench's scans and what is right for them."""
    return [
        {
            "scans": [scan.ranges.tolist() for scan in recording.scans() if len(scan.ranges)],
            "speeds": [min(right_speeds(s)) for s in recording.scans() if len(s.ranges)],
        }
        for recording in recordings
    ]


def handed_in(
    folder: Path, attack: str, table: object = (), changed: tuple[str, str] = ("", "")
) -> Submission:
    """Hand in an attack under the exercise's name, with its table."""
    node, rows = folder / EXERCISE.files[0], folder / "table.json"
    text = WORLDS.read_text().replace(*changed)
    node.write_text(f"{text}\n\nfrom kit import run\n\nrun({attack})\n")
    rows.write_text(json.dumps(table))
    return Submission(node, others=(KIT, rows))


@pytest.mark.parametrize(
    "attack", ["by_order", pytest.param("nearest_scan", marks=pytest.mark.long)]
)
def test_neither_order_nor_likeness_tells_a_students_scans(
    attack: str, forkserver: ForkServer, public: list[Recording], tmp_path: Path
) -> None:
    submission = handed_in(tmp_path, attack, examples(public))
    open_worlds, own_worlds = (points(submission, forkserver, key, BENCH) for key in (None, KEY))
    assert open_worlds >= 35  # all but stop_zone, which wants half a minute as well
    assert own_worlds <= 5


@pytest.mark.long
def test_what_a_new_process_is_given_names_no_world(
    forkserver: ForkServer, public: list[Recording], tmp_path: Path
) -> None:
    def marks(key: str | None) -> list[str]:
        with NodeTrials(handed_in(tmp_path, "fingerprint"), forkserver, seed=key) as trials:
            logs = [trials.get(name).log for name in BENCHES]
        return [line.text for log in logs for line in log if line.text.startswith("MARK")]

    known, own = marks(None), marks(KEY)
    assert len(known) == len(own) == len(BENCHES)
    assert not {*known} & {*own}


@pytest.mark.long
@pytest.mark.parametrize(
    ("attack", "looked", "found"),
    [
        ("predicts_noise", "TRIED", "PREDICTED"),
        ("listens_everywhere", "GRAPH", SCENARIO),
        ("reads_its_surroundings", "LOOKED", SCENARIO),
        ("remembers", "WROTE", "REMEMBERED"),
    ],
)
def test_a_nodes_process_learns_no_world(
    attack: str, looked: str, found: str, forkserver: ForkServer, tmp_path: Path
) -> None:
    """Neither in the first trial nor in the third of a submission."""
    with NodeTrials(handed_in(tmp_path, attack), forkserver, seed=KEY) as trials:
        recordings = [trials.get(name) for name in (SCENARIO, NOISY, "avoid_zones")]
    for recording in recordings:
        said = " ".join(line.text for line in recording.log)
        assert looked in said, (said, recording.outcome)
        assert found not in said
        assert recording.scenario.title not in said


@pytest.mark.long
def test_the_noise_is_predicted_with_the_seed(forkserver: ForkServer, tmp_path: Path) -> None:
    """So the attack that finds no seed would use one."""
    with NodeTrials(REFERENCE, forkserver, seed=KEY) as trials:
        seed = trials.get(NOISY).seed
    changed = ("NUMBERS = {0, 1,", f"NUMBERS = {{{seed}, 0, 1,")
    attack = handed_in(tmp_path, "predicts_noise", changed=changed)
    with NodeTrials(attack, forkserver, seed=KEY) as trials:
        assert f"PREDICTED {seed}" in [line.text for line in trials.get(NOISY).log]
