"""What a grading depends on besides the submitted files: the course's own code and versions."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path

from grader.exercises import ROOT, Exercise
from grader.grading import versions

SUFFIXES = {".py", ".toml", ".xml"}
HASHED = 32  # [characters] of each hash
NO_VERDICT = {"batch", "results", "player"}  # folders of the grader that only organise or show


def fingerprint(exercise: Exercise) -> str:
    """Return a hash of the versions, the simulator, the judge, the host and the checks."""
    digest = hashlib.sha256(json.dumps(versions(), sort_keys=True).encode())
    for path in _sources(exercise):
        digest.update(str(path.relative_to(ROOT)).encode() + b"\0")
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()[:HASHED]


def submission_hash(
    exercise: Exercise, files: Mapping[str, bytes], *, seed: int | None, field: bool, tier: int
) -> str:
    """Return a hash of what was handed in, and of how it is to be graded."""
    digest = hashlib.sha256(json.dumps([exercise.slug, seed, field, tier]).encode())
    for name in sorted(files):
        digest.update(name.encode() + b"\0" + hashlib.sha256(files[name]).digest())
    return digest.hexdigest()[:HASHED]


def _sources(exercise: Exercise) -> Iterator[Path]:
    grader = ROOT / "grader"
    folders = [ROOT / "sim", grader / "host", exercise.checks]
    files = [path for folder in folders for path in folder.rglob("*")]
    files += [*grader.glob("*.py"), *grader.joinpath("checks").glob("*.py")]
    files.append(exercise.folder / "exercise.toml")
    shown = {"cli.py", "report.py", "terminal.py", "doctor.py", "release.py"}
    yield from sorted(
        path for path in set(files)
        if path.suffix in SUFFIXES and path.is_file() and path.name not in shown
        and not NO_VERDICT & set(path.relative_to(ROOT).parts)
    )  # fmt: skip
