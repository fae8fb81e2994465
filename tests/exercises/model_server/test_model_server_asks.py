"""What a server is asked and answers: hostile messages, and scans and requests that cross."""

from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest

from grader.exercises.model_server import server
from grader.exercises.model_server.notes import Request
from grader.exercises.model_server.server import Ask, Detection, asks, read

EPOCH = 1_700_000_000_000_000_000  # [ns]
LIVE = object()
SCANS = tuple(SimpleNamespace(t=i / 2, stamp=i / 2) for i in range(4))  # at 0, 0.5, 1 and 1.5 s
DETECTION = Detection("free", 0.9, 1.0)
Said = tuple[bool, str]  # success, message


def test_a_detection_is_read() -> None:
    assert read(msgspec.json.encode(DETECTION).decode()) == DETECTION
    assert read('{"label": "free", "confidence": 1, "stamp": 1, "more": []}\n') != DETECTION


@pytest.mark.parametrize(
    "message",
    [
        "free",
        "[1, 2]",
        "\ud800",
        "[" * 100_000,
        '{"label": 3, "confidence": 0.5, "stamp": 1.0}',
        '{"label": "a", "confidence": true, "stamp": 1.0}',
        '{"label": "a", "confidence": 0.5, "stamp": -1' + "0" * 400 + "}",
    ],
)
def test_anything_else_is_said_to_be_none(message: str) -> None:
    assert isinstance(read(message), str)


def asked(
    monkeypatch: pytest.MonkeyPatch, live: object, at: float, said: Said | None, **scenario: Any
) -> list[Ask]:
    """Return the one request of a recording, asked at this time [s]."""
    request = Request(at) if said is None else Request(at, "", at + 0.01, *said)
    monkeypatch.setattr(server, "asked", lambda _: [request])
    monkeypatch.setattr(server, "possible_features", lambda _: np.zeros((1, 5)))
    monkeypatch.setattr(server, "_has_model", lambda *_: True)
    recording: Any = SimpleNamespace(
        live=live,
        slack=0.0,
        epoch=EPOCH,
        scans=lambda: SCANS,
        scenario=SimpleNamespace(**{"program": (), "bench_scans": (), **scenario}),
    )
    return list(asks(recording))


def stamped(stamp: float) -> Said:
    return True, msgspec.json.encode(Detection("free", 0.9, EPOCH / 1e9 + stamp)).decode()


@pytest.mark.parametrize(
    ("at", "said", "newest"),
    [
        (1.25, stamped(1.0), 2),
        (1.03, stamped(0.5), 1),  # the scan of 1.0 s was still on its way
        (0.97, stamped(1.0), 2),  # the request was
        (1.25, stamped(0.5), 2),  # too long ago: that answer is wrong
        (0.75, stamped(1.0), 1),  # from the future: wrong too
        (1.03, stamped(0.0), 2),  # neither of the two
        (0.03, (False, "no scan"), -1),  # rightly: it had none yet
        (1.03, (True, "{}"), 2),  # no stamp at all
        (1.25, None, 2),  # no answer at all
    ],
)
def test_the_scan_that_a_server_had_is_one_that_it_can_have_had(
    monkeypatch: pytest.MonkeyPatch, at: float, said: Said | None, newest: int
) -> None:
    (ask,) = asked(monkeypatch, LIVE, at, said)
    assert ask.scan is (SCANS[newest] if newest >= 0 else None)


def test_in_virtual_time_the_newest_scan_is_the_newest(monkeypatch: pytest.MonkeyPatch) -> None:
    (ask,) = asked(monkeypatch, None, 1.0, stamped(0.5))
    assert ask.scan is SCANS[2]


@pytest.mark.parametrize(
    ("live", "at", "judged"),
    [(LIVE, 1.2, False), (LIVE, 2.1, True), (LIVE, 0.9, True), (None, 1.2, True)],
)
def test_a_request_while_the_server_starts_is_not_judged(
    monkeypatch: pytest.MonkeyPatch, live: object, at: float, judged: bool
) -> None:
    programs = (
        SimpleNamespace(start=0.0, supplied=False),
        SimpleNamespace(start=1.0, supplied=False),
        SimpleNamespace(start=1.9, supplied=True),  # ours
    )
    assert len(asked(monkeypatch, live, at, None, program=programs)) == judged
