"""Recordings kept on disk by what made them, so that new checks can judge what was run before.

A recording is kept under the fingerprint of its node, scenario, seed and engine: whatever can
change it changes its name. The files are a contributor's cache, outside the repository.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import zlib
from collections.abc import Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from msgspec.structs import replace

from grader.course.submission import Submission, read_regular_file
from grader.link.log import LogLine
from grader.recording import Compute, Endpoint, Inference, Live, Outcome, Recording, Training
from sim.layout import layout_from_json, layout_to_json
from sim.messages import Message
from sim.scenario import Scenario
from sim.simulation import Truth

FORMAT = 1
CODE = Path(__file__).resolve().parents[2]
ENGINE = ("sim", "grader/host", "grader/link", "grader/models", "grader/recording", "grader/trial")
LIBRARIES = ("ros-jazzy-rclpy", "numpy", "pymunk", "rosbags", "scikit-learn", "onnxruntime")
_SAID_OF_IT = {"title": "", "name": "", "description": ""}  # of a scenario; changes no recording
ENGINES = 3  # whose recordings are kept; those of older ones are deleted

Files = Mapping[str, bytes]


class _Document(msgspec.Struct, frozen=True, array_like=True):
    layout: str
    duration_s: float
    kinds: list[tuple[str, str]]  # topic and type, which messages name by their index
    delivered: list[tuple[int, int, bytes]]  # kind, time [ns], CDR
    published: list[tuple[int, int, bytes]]
    truth: dict[str, tuple[str, bytes]]  # dtype and values
    compute: dict[str, bytes]
    outcome: Outcome
    endpoints: tuple[Endpoint, ...]
    log: tuple[LogLine, ...]
    log_truncated: bool
    training: Training | None
    live: Live | None
    inferences: tuple[Inference, ...]
    charged: bool
    model: bytes | None  # that the training wrote for the node


# made here: several threads that build msgspec's type tables at once crash Python
_DECODER = msgspec.msgpack.Decoder(_Document)


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
            document = _DECODER.decode(zlib.decompress(data))
        except (OSError, zlib.error, msgspec.MsgspecError):
            return None
        return _recording(document, scenario, seed), document.model

    def put(
        self, submission: Submission, recording: Recording, files: Files, model: bytes | None = None
    ) -> None:
        """Keep a recording, unless the machine's speed had a part in it."""
        if recording.charged:
            return
        place = self._place(submission, recording.scenario, recording.seed, files)
        place.parent.mkdir(parents=True, exist_ok=True)
        data = zlib.compress(msgspec.msgpack.encode(_document(recording, model)), level=1)
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
        result.update(msgspec.msgpack.encode(replace(scenario, **_SAID_OF_IT)))
        own = {path.name: read_regular_file(path) for path in (submission.path, *submission.others)}
        for folder in (own, files):
            for name, data in sorted(folder.items()):
                result.update(f"{name} {len(data)}\n".encode() + data)
        name = result.hexdigest()[:32]
        return self._root / self._engine / name[:2] / name[2:]


@cache
def fingerprint_of_engine() -> str:
    """Return a name for all that a recording depends on besides its node, scenario and seed."""
    result = hashlib.sha256()
    for library in LIBRARIES:
        try:
            result.update(f"{library} {version(library)}\n".encode())
        except PackageNotFoundError:
            continue
    for room in ENGINE:
        for path in sorted((CODE / room).rglob("*.py")):
            result.update(path.relative_to(CODE).as_posix().encode() + path.read_bytes())
    return result.hexdigest()[:16]


def _document(recording: Recording, model: bytes | None) -> _Document:
    kinds: dict[tuple[str, str], int] = {}

    def rows(messages: tuple[Message, ...]) -> list[tuple[int, int, bytes]]:
        return [(kinds.setdefault((m.topic, m.type), len(kinds)), m.time, m.data) for m in messages]

    delivered, published = rows(recording.delivered), rows(recording.published)
    truth, compute = vars(recording.truth), vars(recording.compute)
    return _Document(
        layout=layout_to_json(recording.layout),
        duration_s=recording.duration_s,
        kinds=list(kinds),
        delivered=delivered,
        published=published,
        truth={name: (array.dtype.str, array.tobytes()) for name, array in truth.items()},
        compute={name: array.tobytes() for name, array in compute.items()},
        outcome=recording.outcome,
        endpoints=recording.endpoints,
        log=recording.log,
        log_truncated=recording.log_truncated,
        training=recording.training,
        live=recording.live,
        inferences=recording.inferences,
        charged=recording.charged,
        model=model,
    )


def _recording(document: _Document, scenario: Scenario, seed: int) -> Recording:
    def messages(rows: list[tuple[int, int, bytes]]) -> tuple[Message, ...]:
        return tuple(Message(*document.kinds[kind], time, data) for kind, time, data in rows)

    truth: dict[str, Any] = {
        name: np.frombuffer(data, dtype) for name, (dtype, data) in document.truth.items()
    }
    return Recording(
        scenario=scenario,
        layout=layout_from_json(document.layout),
        seed=seed,
        duration_s=document.duration_s,
        delivered=messages(document.delivered),
        published=messages(document.published),
        truth=Truth(**truth),
        outcome=document.outcome,
        endpoints=document.endpoints,
        log=document.log,
        log_truncated=document.log_truncated,
        compute=Compute(**{name: np.frombuffer(data) for name, data in document.compute.items()}),
        training=document.training,
        live=document.live,
        inferences=document.inferences,
        charged=document.charged,
    )
