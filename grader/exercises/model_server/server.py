"""What the student's server has to answer: occasions for each request of the grader's client.

success     it detects or refuses as it has to
reason      a refusal says why
detection   the message is a detection: label, confidence and stamp of the newest scan
features    what the model was asked about
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import msgspec
import numpy as np

from grader.checks.case import Allowed, Case, Runs, Said, exactly
from grader.checks.commands import published
from grader.checks.predictions import loads, questions
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.exercises.model_server.notes import (
    ASKED,
    NEAR,
    START_UP,
    TOLD,
    Answered,
    notes,
    require_ours,
)
from grader.models.features import possible_features, scan_features, spell_features
from grader.recording import Inference, Recording, Scan
from sim.messages import UINT32

MAX_SCAN_AGE = 1.0  # [s] an older scan gives no detection
FEATURE_TOLERANCE = 2e-3  # [m]
TOLERANCE = 1e-3  # of a confidence, and of a stamp [s]
UNDER_WAY = 0.06  # [s] a scan may take to reach the server, in real time
LONGEST = 10_000  # characters of a message; a detection has about a hundred
QUOTED = 200  # characters of what a server said
SERVER, MODEL = "detection_server.py", "detection_model.pkl"
NO_MODEL = ("garbage", "foreign", "empty")  # probes that no server can load
DETECTS, REFUSES = "true", "false"  # what success may be
FORM = "a JSON object with label, confidence and stamp"
FEATURES = "front min, mean, std, left min, right min"
QUESTION, FAILS, UNASKED = "question to the model", "one that fails", "none"


class Detection(msgspec.Struct, frozen=True):
    """What the message of an answer with success has to hold."""

    label: str
    confidence: float
    stamp: float  # [s]


@dataclass(frozen=True, eq=False)
class Ask:
    """A request of the grader's client to the student's server."""

    recording: Recording
    at: float  # [s]
    said: Answered | None
    until: float  # [s] when its answer came
    newest: int  # the newest scan that the server had; -1: none

    @property
    def scan(self) -> Scan | None:
        """That scan."""
        return self.recording.scans()[self.newest] if self.newest >= 0 else None

    @property
    def fails(self) -> bool:
        """The model fails, asked about that scan."""
        bench = self.recording.scenario.bench_scans
        return bool(bench) and self.newest >= 0 and "fails" in bench[self.newest].tags

    @property
    def what(self) -> str:
        """The request in words, and why only a refusal is right."""
        bench, scan = self.recording.scenario.bench_scans, self.scan
        words = f"asked at {self.at:.2f} s"
        if scan is not None:
            words += f", {self.at - scan.stamp:.2f} s after the newest scan"
            words = f"asked about “{bench[self.newest].label}”" if bench else words
        return f"{words}: {self.reason}" if self.reason else words

    @cached_property
    def reason(self) -> str:
        """Why only a refusal is right; empty if a detection is."""
        if not _has_model(self.recording, self.at):
            return "its model can't be loaded"
        if self.scan is None:
            return "there is no scan"
        if self.at - self.scan.stamp > MAX_SCAN_AGE + NEAR:
            return "the scan is too old"
        if np.isnan(possible_features(self.scan)).any(axis=1).all():
            return "a sector has no usable reading"
        return "the model fails" if self.fails else ""

    @property
    def right(self) -> frozenset[str]:
        """Which values of success are right."""
        if self.reason or self.scan is None:
            return frozenset({REFUSES})
        nearly_blind = bool(np.isnan(possible_features(self.scan)).any())
        nearly_old = self.at - self.scan.stamp > MAX_SCAN_AGE - NEAR
        return frozenset({DETECTS, REFUSES} if nearly_blind or nearly_old else {DETECTS})

    @property
    def stamp(self) -> float:
        """The stamp of that scan [s]."""
        return self.recording.epoch / 1e9 + (self.scan.stamp if self.scan else 0.0)

    def questions(self, *methods: str) -> list[Inference]:
        """Return what the model was asked between that scan and the answer."""
        if self.scan is None:
            return []
        since = self.scan.t - (0.0 if self.recording.live is None else UNDER_WAY)
        return [i for m in methods for i in questions(self.recording, m, since, self.until)]

    def fits(self) -> bool:
        """Return whether the answer is about that scan, or a refusal that it allows."""
        if self.said is None or not self.said.success:
            return REFUSES in self.right
        said = read(self.said.message)
        return isinstance(said, Detection) and abs(said.stamp - self.stamp) <= TOLERANCE


def asks(recording: Recording) -> Iterator[Ask]:
    """Yield each request of the grader's client to the server, with its answer."""
    require_ours(recording, ASKED)
    answers = {note.number: (at, note) for at, note in notes(recording, TOLD)}
    scans, near = recording.scans(), UNDER_WAY + recording.slack
    for at, asked in published(recording, ASKED, UINT32):
        until, said = answers.get(int(asked.data), (at, None))
        said = said if isinstance(said, Answered) else None
        newest = sum(scan.t <= at for scan in scans) - 1
        ask = Ask(recording, at, said, until, newest)
        if recording.live is None:
            yield ask
        elif not _just_started(recording, at):
            # a scan that was sent at nearly the same moment may have come sooner or later
            others = [
                Ask(recording, at, said, until, newest + step)
                for step, first in ((-1, newest), (1, newest + 1))
                if 0 <= first < len(scans) and abs(at - scans[first].t) <= near
            ]
            yield next((each for each in (ask, *others) if said and each.fits()), ask)


def _just_started(recording: Recording, at: float) -> bool:
    """Return whether one of the student's programs started shortly before this.

    A process takes time to start, and DDS to discover it: a request meanwhile reaches no server.
    """
    programs = recording.scenario.program
    late = [program.start for program in programs if program.start > 0.0 and not program.supplied]
    return any(0.0 < at - start < START_UP for start in late)


def _has_model(recording: Recording, at: float) -> bool:
    """Return whether the server that runs at a time [s] was started with a model that loads."""
    scenario = recording.scenario
    path = str(scenario.node.parameters.get("model_path", MODEL))
    for program in scenario.program:
        if program.file == SERVER and program.start <= at < (program.stop or math.inf):
            path = "".join(program.arguments[-1:]).partition("model_path:=")[2] or path
    model = scenario.node.models.get(path)
    return model is not None and model.probe not in NO_MODEL


def cases(recording: Recording) -> Iterator[Case]:
    """Yield the occasions of each request."""
    for ask in asks(recording):
        yield _success(ask)
        if ask.right == {REFUSES}:
            yield _reason(ask)
        if ask.right == {DETECTS}:
            yield _detection(ask)
            yield _features(ask)


def _success(ask: Ask) -> Case:
    text = ask.said.message[:QUOTED] if ask.said else ""
    success = str(ask.said.success).lower() if ask.said else "no answer"
    allowed, said = {"success": ask.right}, {"success": success, "text": text}
    if ask.fails:
        asked = ask.questions("predict", "predict_proba")
        failed = any(i.failed or not all(map(math.isfinite, i.said)) for i in asked)
        allowed[QUESTION], said[QUESTION] = frozenset({FAILS}), FAILS if failed else UNASKED
    return Case(ask.at, ask.what, frozenset({"success"}), allowed, said)


def _reason(ask: Ask) -> Case:
    given = ask.said is not None and ask.said.message.strip()
    allowed, said = {"message": frozenset({"a reason"})}, {"message": "a reason" if given else ""}
    return Case(ask.at, ask.what, frozenset({"reason"}), allowed, said)


def _detection(ask: Ask) -> Case:
    words = [word for i in ask.questions("predict") for word in _labels(i)]
    sure = [number for i in ask.questions("predict_proba") for number in i.said]
    allowed: dict[str, Allowed] = {
        "message": frozenset({FORM}),
        "label": frozenset(words),
        "confidence": exactly(*sure),
        "stamp": exactly(ask.stamp),
    }
    text = ask.said.message if ask.said else ""
    said = read(text)
    if isinstance(said, str):
        return Case(ask.at, ask.what, frozenset({"detection"}), allowed, {"message": said})
    spelled: dict[str, Said] = {
        "message": FORM,
        "label": next((w for w in words if _is_same(said.label, w)), repr(said.label)[:QUOTED]),
        "confidence": said.confidence,
        "stamp": said.stamp,
        "text": text[:QUOTED],
    }
    return Case(ask.at, ask.what, frozenset({"detection"}), allowed, spelled)


def _features(ask: Ask) -> Case:
    """Return the case of the features, which a label of the model `describes` spells."""
    assert ask.scan is not None  # where a detection is right
    right, name = possible_features(ask.scan), spell_features(scan_features(ask.scan))
    asked = ask.questions("predict", "predict_proba")
    given = [five for i in asked for label in _labels(i) if (five := _five(label)) is not None]
    wrong = [f for f in given if (np.abs(f - right).max(axis=1) > FEATURE_TOLERANCE).all()]
    said = spell_features(wrong[0]) if wrong else name if given else UNASKED
    allowed = {FEATURES: frozenset({name})}
    return Case(ask.at, ask.what, frozenset({"features"}), allowed, {FEATURES: said})


def loads_once(runs: Runs) -> None:
    """Fail unless the model is loaded once in each trial, by all processes, and is asked."""
    for recording in runs:
        require_alive(recording)
        times = [load.asked / 1e9 for load in loads(recording)]
        if len(times) == 1 and len(recording.inferences) > 1:
            continue
        fail(
            f"the model was loaded {len(times)} times in {recording.name}",
            expected="one load, in the server's constructor, and then questions",
            actual=f"{len(times)} loads, {len(recording.inferences) - len(times)} questions",
            at=times[-1] if times else 0.0,
            recording=recording,
            help="pickle.load belongs in the constructor of the server and nowhere else: one "
            "process has the model for all, and a model that failed once is still the same one.",
        )


def _labels(asked: Inference) -> list[str]:
    """Return what a model said to a question; numbers, if it has no words."""
    return [*asked.labels] or [f"{number:g}" for number in asked.said]


def _five(label: str) -> np.ndarray | None:
    """Return the five features [m] in a label of the model `describes`; None: another label."""
    try:
        numbers = np.array(label.split(), dtype=float)
    except ValueError:
        return None
    return numbers if len(numbers) == 5 and np.isfinite(numbers).all() else None


def read(message: str) -> Detection | str:
    """Return the detection in a message; what is wrong, if it is none."""
    if len(message) > LONGEST:  # several checks read it
        return f"{len(message):,} characters"
    try:
        return msgspec.json.decode(message, type=Detection)
    except (ValueError, RecursionError) as error:  # thousands of nested brackets, for example
        return f"none: {error}"


def _is_same(label: str, word: str) -> bool:
    """Return whether a label is the model's: "3", "3.0" and "[3]" are one number."""
    try:
        return label == word or float(label.strip("[]")) == float(word)
    except ValueError:
        return False
