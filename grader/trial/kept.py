"""Recordings kept on disk by what made them, so that new checks can judge what was run before.

A recording is kept under the fingerprint of its node, scenario, seed and engine: whatever can
change it changes its name. The files are a contributor's own cache, which git ignores; they are
pickled, so nobody else's belong there.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import shutil
import sys
import zlib
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import msgspec

from grader.course.submission import Submission
from grader.recording import Recording
from sim.scenario import Scenario

FORMAT = 2
# what unpickling may raise, as the library reference lists it
BROKEN = (pickle.UnpicklingError, AttributeError, EOFError, ImportError, IndexError)
CODE = Path(__file__).resolve().parents[2]
RECORDINGS = CODE / "build" / "recordings"  # those of the proof and of the tests
ENGINE = (
    "sim", "rclpy_virtual_time/host", "rclpy_virtual_time/link", "grader/advice", "grader/colcon",
    "grader/hosted", "grader/models", "grader/recording", "grader/trial",
)  # fmt: skip
LIBRARIES = ("ros-rclpy", "rclpy", "numpy", "pymunk", "rosbags", "scikit-learn", "onnxruntime")
_SAID_OF_IT = {"title": "", "name": "", "description": ""}  # of a scenario; changes no recording
ENGINES = 3  # whose recordings are kept; those of older ones are deleted

Files = Mapping[str, bytes]


class KeptRecordings:
    """A folder of recordings, one file each.

    Parameters
    ----------
    folder
        Is made where it doesn't exist.
    engine
        Take what another engine recorded, where digests have shown that both record the same.
    blind
        Find nothing: everything is recorded anew.
    """

    def __init__(self, folder: Path, engine: str = "", *, blind: bool = False) -> None:
        self._root, self._engine = folder, engine or fingerprint_of_engine()
        self._blind = blind

    def anew(self) -> KeptRecordings:
        """Return the same folder, in which nothing is found."""
        return KeptRecordings(self._root, self._engine, blind=True)

    def get(
        self, submission: Submission, scenario: Scenario, seed: int, files: Files
    ) -> tuple[Recording, bytes | None] | None:
        """Return a recording, and the model that was written if it is one of a training.

        `files` are those that the node found in its working folder.
        """
        if self._blind:
            return None
        try:
            data = self._place(submission, scenario, seed, files).read_bytes()
            recording, model = pickle.loads(zlib.decompress(data))
        except (OSError, zlib.error, *BROKEN):
            return None
        return replace(recording, scenario=scenario), model

    def put(
        self, submission: Submission, recording: Recording, files: Files, model: bytes | None = None
    ) -> None:
        """Keep a recording, unless the machine's speed had a part in it."""
        if recording.charged:
            return
        place = self._place(submission, recording.scenario, recording.seed, files)
        place.parent.mkdir(parents=True, exist_ok=True)
        data = zlib.compress(pickle.dumps((recording, model)), level=1)
        part = place.with_suffix(f".{os.getpid()}")
        part.write_bytes(data)
        part.replace(place)

    def tidy(self) -> None:
        """Delete the recordings of all engines but the last few."""
        own = self._root / self._engine
        own.mkdir(parents=True, exist_ok=True)
        own.touch()
        engines = sorted(self._root.iterdir(), key=lambda path: path.stat().st_mtime)
        for old in engines[:-ENGINES]:
            shutil.rmtree(old)

    def _place(self, submission: Submission, scenario: Scenario, seed: int, files: Files) -> Path:
        result = hashlib.sha256(f"{FORMAT} {seed} {submission.problem}\n".encode())
        result.update(msgspec.msgpack.encode(msgspec.structs.replace(scenario, **_SAID_OF_IT)))
        result.update(repr(submission.package and submission.package.programs).encode())
        for folder in (submission.contents(), files):
            for name, data in sorted(folder.items()):
                result.update(f"{name} {len(data)}\n".encode() + data)
        name = result.hexdigest()[:32]
        return self._root / self._engine / name[:2] / name[2:]


@cache
def fingerprint_of_engine() -> str:
    """Return a name for all that a recording depends on besides its node, scenario and seed."""
    result = hashlib.sha256(sys.version.encode())
    for library in LIBRARIES:
        try:
            result.update(f"{library} {version(library)}\n".encode())
        except PackageNotFoundError:
            continue
    every = [path for room in ENGINE for path in (CODE / room).rglob("*.py")]
    for path in sorted([*every, CODE / "rclpy_portable" / "cdr.py"]):  # it writes own messages, too
        result.update(path.relative_to(CODE).as_posix().encode() + path.read_bytes())
    return result.hexdigest()[:16]
