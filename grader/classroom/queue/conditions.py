"""What a grading depends on besides the submitted files: the course's own code and versions."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path

from grader.course.exercises import JUDGE, ROOT, Exercise
from grader.course.students import Seed
from grader.grading.grading import versions

SUFFIXES = {".py", ".toml", ".xml"}
HASHED = 32  # [characters] of each hash
# packages on which a verdict depends; the others only organise or show
VERDICT = (
    "grader/advice", "grader/checks", "grader/colcon", "grader/course", "grader/exercises",
    "grader/grading", "grader/hosted", "grader/models", "grader/recording", "grader/trial",
    "rclpy_virtual_time/host", "rclpy_virtual_time/link",
)  # fmt: skip


def fingerprint(exercise: Exercise) -> str:
    """Return a hash of the versions, the simulator, the judge, the host and the checks."""
    digest = hashlib.sha256(json.dumps(versions(), sort_keys=True).encode())
    for path in _sources(exercise):
        digest.update(str(path.relative_to(ROOT)).encode() + b"\0")
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()[:HASHED]


def submission_hash(
    exercise: Exercise, files: Mapping[str, bytes], *, seed: Seed | None, field: bool
) -> str:
    """Return a hash of the submitted files and of how they are to be graded."""
    digest = hashlib.sha256(json.dumps([exercise.slug, seed, field, 1]).encode())
    for name in sorted(files):
        digest.update(name.encode() + b"\0" + hashlib.sha256(files[name]).digest())
    return digest.hexdigest()[:HASHED]


def _sources(exercise: Exercise) -> Iterator[Path]:
    """Yield what a verdict depends on; a new exercise or world changes no other exercise's."""
    sim = ROOT / "sim"
    rooms = [sim, *(ROOT / room for room in VERDICT)]
    files = {path for room in rooms for path in room.rglob("*") if path.suffix in SUFFIXES}
    others = [folder for folder in JUDGE.iterdir() if folder.is_dir() and folder != exercise.judge]
    others += [sim / each for each in ("live", "launch", "scenarios", "worlds")]
    mine = {path for path in files if not any(map(path.is_relative_to, others))}
    own = "".join(path.read_text("utf-8") for path in exercise.judge.glob("scenarios/*.toml"))
    worlds = {path for path in (sim / "worlds").glob("*.toml") if f'"{path.stem}"' in own}
    yield from sorted({*mine, *worlds, exercise.folder / "exercise.toml"})
