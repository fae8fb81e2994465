"""The field checks of exercise 6: no points, but the badge *field-ready*."""

from __future__ import annotations

from itertools import pairwise

import pytest

from grader.checks.old_field import FieldSuite
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.exercises.model_server.answers import require_contract
from grader.exercises.model_server.clients import detections, require_heartbeat
from grader.exercises.model_server.contract import ASK_PERIOD, HAIR, NEXT_REQUEST, ROLES
from grader.recording import Recording

LONGEST_WAIT = 1.6  # [s] between two detections of one client, with a model that takes 0.3 s

Recordings = tuple[Recording, ...]

server = FieldSuite(
    "model_server", require_contract, needs=("server_wiring",), nodes=("detection_server",)
)

test_field_lds01 = server.lds01("detect_field_lds01")
test_field_wide_lidar = server.wide_lidar("detect_field_wide")
test_field_best_effort = server.best_effort("detect_field_best_effort")
test_field_speckle = server.speckle(
    "detect_field_speckle", title="Takes NaN speckle, noise and lost scans in its stride."
)


@pytest.mark.check(field=True, scenarios=("detect_field_slow_model",), needs=("client_wiring",))
def test_field_slow_model(recordings: Recordings) -> None:
    """With a model that takes 0.3 s, each of the three clients gets its answers in time."""
    for recording in recordings:
        require_alive(recording)
        require_heartbeat(recording)
        for role in ROLES:
            _require_detections(recording, role, 0.0, recording.duration_s, LONGEST_WAIT)


@pytest.mark.check(field=True, scenarios=("detect_field_restart",), needs=("client_wiring",))
def test_field_restart(recordings: Recordings) -> None:
    """The server is killed and restarted, and everything goes on."""
    for recording in recordings:
        require_alive(recording)
        require_heartbeat(recording)
        servers = [p for p in recording.scenario.program if p.file == "detection_server.py"]
        for life in servers:
            end = life.stop or recording.duration_s
            for role in ROLES:
                _require_detections(
                    recording, role, life.start, end, NEXT_REQUEST + HAIR, ASK_PERIOD + HAIR
                )


def _require_detections(
    recording: Recording,
    role: str,
    begin: float,
    end: float,
    first: float,
    wait: float | None = None,
) -> None:
    """Fail if a role waits over `first` [s] for its first detection, or `wait` [s] for the next."""
    heard = [t for t, who, _ in detections(recording) if who == role and begin <= t <= end]
    limits = [first] + [wait or first] * len(heard)
    for limit, (before, after) in zip(limits, pairwise([begin, *heard, end]), strict=True):
        if after - before > limit:
            fail(
                f"{role}_client has to wait for a detection for {after - before:.2f} s",
                expected=f"one within {limit:.2f} s",
                actual=f"none from {before:.2f} s to {after:.2f} s",
                at=before,
                recording=recording,
                help="Is the server done with a request in time to answer two more within 1 s? Do "
                "old scans wait in the queue of its subscription (depth)? Does a new server find "
                "traces of the old one?",
            )
