"""What the student's server has to answer: occasions for each request of the grader's client.

success     it detects or refuses as it has to
reason      a refusal says why
detection   the message is a detection: label, confidence and stamp of the newest scan
features    what the model was asked about
loads       how often the model was loaded, by all processes
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from grader.checks.case import Allowed, Case, Said, exactly
from grader.checks.predictions import loads, questions
from grader.checks.verbs import TOLERANCE
from grader.exercises.model_server.notes import NEAR, START_UP, Request, asked
from grader.models.features import NAMES, possible_features
from grader.recording import Inference, Recording, Scan

MAX_SCAN_AGE = 1.0  # [s] an older scan gives no detection
FEATURE_TOLERANCE = 1e-3  # [m]
UNDER_WAY = 0.06  # [s] a scan may take to reach the server, in real time
QUOTED = 200  # characters of what a server said
METHODS = ("predict", "predict_proba")
SERVER, MODEL = "detection_server.py", "detection_model.pkl"
NO_MODEL = ("garbage", "foreign", "empty")  # probes that no server can load
DETECTS, REFUSES = frozenset({"true"}), frozenset({"false"})  # what success may be
FORM = "a JSON object with label, confidence and stamp"
REASON, LOADS = "a reason", "loads of the model"


class Detection(msgspec.Struct, frozen=True):
    """What the message of an answer with success has to hold."""

    label: str
    confidence: float
    stamp: float  # [s]


@dataclass(frozen=True, eq=False)
class Ask:
    """A request of the grader's client to the student's server, and what is right."""

    at: float  # [s]
    what: str
    said: Request | None  # with its answer
    scan: Scan | None  # the newest that the server had
    stamp: float  # of that scan [s]; NaN: there is none
    right: frozenset[str]  # values of success

    @property
    def fits(self) -> bool:
        """The answer is about that scan, or a refusal that it allows."""
        if self.said is None or not self.said.success:
            return self.said is not None and self.right >= REFUSES
        said = read(self.said.message)
        return isinstance(said, Detection) and abs(said.stamp - self.stamp) <= TOLERANCE


def cases(recording: Recording) -> Iterator[Case]:
    """Yield the occasions of each request, and how often the model was loaded."""
    times = [load.asked / 1e9 for load in loads(recording)]
    once, count = {LOADS: frozenset({"1"})}, {LOADS: str(len(times))}
    yield Case(max(times, default=0.0), "all programs together", frozenset({"loads"}), once, count)
    for ask in asks(recording):
        success = {"success": str(ask.said.success).lower()} if ask.said else {}
        yield Case(ask.at, ask.what, frozenset({"success"}), {"success": ask.right}, success)
        if ask.right == REFUSES:
            given = REASON if ask.said and ask.said.message.strip() else ""
            right = {"message": frozenset({REASON})}
            yield Case(ask.at, ask.what, frozenset({"reason"}), right, {"message": given})
        if ask.right == DETECTS and ask.scan is not None:
            since = ask.scan.t - (0.0 if recording.live is None else UNDER_WAY)
            until = ask.said.answered if ask.said else ask.at
            predict, proba = (questions(recording, m, since, until) for m in METHODS)
            yield _detection(ask, predict, proba)
            yield from _features(ask, ask.scan, [*predict, *proba])


def asks(recording: Recording) -> Iterator[Ask]:
    """Yield each request of the grader's client to the server, with its answer."""
    scans, live = recording.scans(), recording.live is not None
    near = UNDER_WAY + recording.slack if live else -1.0
    starts = [each.start for each in recording.scenario.program if not each.supplied]
    for request in asked(recording):
        at, said = request.at, request if math.isfinite(request.answered) else None
        if live and any(start and 0.0 < at - start < START_UP for start in starts):
            continue  # it reached no server
        newest = sum(scan.t <= at for scan in scans) - 1
        places = [newest]  # a scan that was sent at nearly the same moment may have come or not
        if newest >= 0 and at - scans[newest].t <= near:
            places.append(newest - 1)
        if newest + 1 < len(scans) and scans[newest + 1].t - at <= near:
            places.append(newest + 1)
        found = [_ask(recording, at, place, said) for place in places]
        yield next((ask for ask in found if ask.fits), found[0])


def _ask(recording: Recording, at: float, newest: int, said: Request | None) -> Ask:
    """Return a request, and what is right if this scan is the newest (-1: there is none)."""
    scan = recording.scans()[newest] if newest >= 0 else None
    spec = recording.scenario.bench_scans[newest:][:1] if scan else ()
    blind = np.isnan(possible_features(scan)).any(axis=1) if scan else np.array([True])
    age = at - scan.stamp if scan else math.inf
    reasons = {
        "its model can't be loaded": not _has_model(recording, at),
        "there is no scan": scan is None,
        "the scan is too old": age > MAX_SCAN_AGE + NEAR,
        "a sector has no usable reading": blind.all(),
        "the model fails": any("fails" in each.tags for each in spec),
    }
    reason = next((f": {why}" for why, holds in reasons.items() if holds), "")
    may_refuse = blind.any() or age > MAX_SCAN_AGE - NEAR
    about = f"“{spec[0].label}”" if spec else "the newest scan"
    what = f"asked {age:.2f} s after {about}" if scan else "asked"
    answer = f"; it said “{said.message[:QUOTED]}”" if said else ""
    return Ask(
        at=at,
        what=what + reason + answer,
        said=said,
        scan=scan,
        stamp=recording.epoch / 1e9 + scan.stamp if scan else math.nan,
        right=REFUSES if reason else DETECTS | REFUSES if may_refuse else DETECTS,
    )


def _has_model(recording: Recording, at: float) -> bool:
    """Return whether the server that runs at a time [s] was started with a model that loads."""
    scenario = recording.scenario
    path = str(scenario.node.parameters.get("model_path", MODEL))
    for program in scenario.program:
        if program.file == SERVER and program.start <= at < (program.stop or math.inf):
            path = "".join(program.arguments[-1:]).partition("model_path:=")[2] or path
    model = scenario.node.models.get(path)
    return model is not None and model.probe not in NO_MODEL


def _detection(ask: Ask, predict: Sequence[Inference], proba: Sequence[Inference]) -> Case:
    allowed: dict[str, Allowed] = {
        "message": frozenset({FORM}),
        "label": frozenset(label for question in predict for label in _labels(question)),
        "confidence": exactly(*(number for question in proba for number in question.said)),
        "stamp": exactly(ask.stamp),
    }
    found = read(ask.said.message if ask.said else "")
    said: dict[str, Said] = {"message": found if isinstance(found, str) else FORM}
    if isinstance(found, Detection):
        label = found.label[:QUOTED]
        said |= {"label": label, "confidence": found.confidence, "stamp": found.stamp}
    missing = [
        name for name, asked in (("predict", predict), ("predict_proba", proba)) if not asked
    ]
    what = f"{ask.what}, and {missing[0]} was not asked" if missing else ask.what
    return Case(ask.at, what, frozenset({"detection"}), allowed, said)


def _features(ask: Ask, scan: Scan, asked: Sequence[Inference]) -> Iterator[Case]:
    """Yield each row that the model was asked about; labels of the model `describes` spell it."""
    right = possible_features(scan)
    least, most = right.min(axis=0) - FEATURE_TOLERANCE, right.max(axis=0) + FEATURE_TOLERANCE
    allowed = {name: ((low, high),) for name, low, high in zip(NAMES, least, most, strict=True)}
    rows = [row for question in asked for label in question.labels if (row := _numbers(label))]
    for row in rows or [[]]:
        said = dict(zip(NAMES, row, strict=False))
        yield Case(ask.at, ask.what, frozenset({"features"}), allowed, said)


def read(message: str) -> Detection | str:
    """Return the detection in a message; what is wrong, if it is none."""
    try:
        return msgspec.json.decode(message, type=Detection)
    except (ValueError, RecursionError) as error:  # thousands of nested brackets, for example
        return f"none: {error}"


def _labels(question: Inference) -> list[str]:
    """Return what a model said to a question; of numbers both spellings, 3 and 3.0."""
    return [*question.labels] or [each for n in question.said for each in (f"{n:g}", f"{n}")]


def _numbers(label: str) -> list[float]:
    try:
        return [float(word) for word in label.split()]
    except ValueError:
        return []
