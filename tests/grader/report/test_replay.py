import base64
import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec import structs

from grader.recording import Outcome, Recording
from grader.report.page import page_html, page_payload
from grader.report.replay import (
    MAX_BEAMS,
    MAX_LOG,
    MAX_LOG_LINES,
    millimetres,
    moments_of,
    replay_payload,
)
from rclpy_virtual_time.link.log import LogLine
from sim.messages import pose_stamped, twist
from sim.scenario import ProgramSpec, ScriptEvent
from sim.scenario_files import scenario_from_toml
from sim.simulation import Simulation

SECOND = 10**9

WORLD = """
title = "Towards a wall"
duration = {duration}
[world]
description = "a wall"
[[world.walls]]
points = [[2.0, -2.0], [2.0, 2.0]]
[[world.boxes]]
center = [1.0, 1.5]
size = [0.4, 0.4]
[[world.carts]]
size = [0.4, 0.3]
path = [[0.0, -1.0, -1.5], [2.0, -1.0, 1.5]]
[robot]
start = [0.0, 0.0, 0.0]
[lidar]
profile = "{profile}"
"""


def drive(duration: float = 6.0, profile: str = "default") -> Recording:
    """The robot drives straight into the wall."""
    text = WORLD.format(duration=duration, profile=profile)
    scenario = scenario_from_toml(text, "test.toml")
    simulation = Simulation(scenario)
    commands = [(t, 0.5, 0.0) for t in range(0, int(duration * SECOND), SECOND // 10)]
    delivered = simulation.advance(int(duration * SECOND), commands)
    return Recording(
        scenario=scenario,
        layout=simulation.layout,
        seed=simulation.seed,
        duration_s=duration,
        delivered=tuple(delivered),
        published=tuple(twist(time=t, linear_x=v, angular_z=w) for t, v, w in commands),
        truth=simulation.truth(),
        outcome=Outcome("completed", at=duration),
        endpoints=(),
        log=(LogLine(time=SECOND, level="info", text="hello"),),
    )


@pytest.fixture(scope="module")
def recording() -> Recording:
    return drive()


def test_a_run_is_told_by_its_payload(recording: Recording) -> None:
    payload = replay_payload(recording, [])
    truth = payload["truth"]
    assert len(truth["t"]) == pytest.approx(6.0 * 20, abs=2)
    assert np.diff(truth["t"]) == pytest.approx(0.05, abs=0.011)
    assert truth["x"][-1] == pytest.approx(2.0 - 0.17, abs=0.01)
    assert max(truth["contact"]) == 1
    assert min(truth["clearance"]) == 0.0
    assert payload["bench"] is False
    assert payload["world"]["walls"] == [[[2.0, -2.0], [2.0, 2.0]]]
    assert payload["carts"][0]["y"][0] == -1.5
    assert payload["commands"]["v"] == [0.5] * 60
    assert payload["log"] == [{"t": 1.0, "level": "info", "text": "hello"}]
    json.dumps(payload, allow_nan=False)


def test_contact_and_least_clearance_survive_the_thinning(recording: Recording) -> None:
    touched = np.zeros(len(recording.truth.t), dtype=bool)
    touched[7] = True
    clearance = np.ones(len(touched))
    clearance[7] = 0.123
    blip = replace(recording.truth, contact=touched, clearance=clearance)
    truth = replay_payload(replace(recording, truth=blip), [])["truth"]
    assert sum(truth["contact"]) == 1
    assert min(truth["clearance"]) == 0.123


def test_scans_can_be_read_back(recording: Recording) -> None:
    scans = replay_payload(recording, [])["scans"]
    mm = np.frombuffer(base64.b64decode(scans["mm"]), dtype="<u2").reshape(-1, scans["beams"])
    assert len(mm) == len(scans["t"]) == len(recording.scans())
    ahead = round(-scans["angle_min"] / scans["angle_increment"])
    assert mm[0, ahead] == pytest.approx(2000, abs=5)
    assert np.any(mm[0] == 65535)


def test_a_wide_fast_lidar_is_thinned() -> None:
    recording = drive(2.0, "wide")
    scans = replay_payload(recording, [])["scans"]
    assert scans["beams"] <= MAX_BEAMS
    assert len(scans["t"]) <= 2.0 * 10 + 1
    whole = recording.scans()[0]
    covered = scans["beams"] * scans["angle_increment"]
    assert covered == pytest.approx(len(whole.ranges) * whole.angle_increment, abs=0.02)


def test_millimetres() -> None:
    ranges = np.array([0.0, 1.234, math.inf, -math.inf, math.nan, 99.0, -1.0], dtype=np.float32)
    assert millimetres(ranges).tolist() == [0, 1234, 65535, 65534, 65533, 65532, 0]


def test_goals_may_be_no_numbers_and_a_node_may_say_nothing(recording: Recording) -> None:
    goals = (
        pose_stamped(time=SECOND, x=1.0, y=2.0),
        pose_stamped(time=2 * SECOND, x=math.nan, y=math.inf),
    )
    silent = replace(recording, published=(), delivered=goals, log=())
    payload = replay_payload(silent, [])
    assert payload["goals"] == [{"t": 1.0, "x": 1.0, "y": 2.0}, {"t": 2.0, "x": None, "y": None}]
    assert payload["scans"] is None
    assert payload["commands"] == {"t": [], "v": [], "w": []}
    page_html(page_payload(None, [silent], "Silent"))


def test_deeds_are_told_with_the_answer_that_came_after_them(recording: Recording) -> None:
    setter = ProgramSpec("parameter_setter.py", True, ("agent", "0.5 near?", "1.0 v:=1.0, w:=2.0"))
    script = (ScriptEvent(at=2.0, e_stop=True), ScriptEvent(at=9.0, e_stop=False))
    scenario = structs.replace(recording.scenario, program=(setter,), script=script)
    said = [(0, "v:=1.0: accepted"), (1, "w:=2.0: accepted"), (1, "v:=1.0: refused no")]
    log = tuple(LogLine(time=t * SECOND, level="info", text=text) for t, text in said)
    told = replay_payload(replace(recording, scenario=scenario, log=log), [])["deeds"]
    texts = ["v:=1.0: refused: no", "w:=2.0: accepted", "e-stop pressed"]
    assert [deed["text"] for deed in told] == texts


def test_a_log_without_end_is_cut(recording: Recording) -> None:
    for text, lines in (("x" * 5000, MAX_LOG // 2002), ("x", MAX_LOG_LINES), ("\x01" * 99, 167)):
        said = (LogLine(time=SECOND, level="info", text=text),) * (MAX_LOG_LINES + 10)
        log = replay_payload(replace(recording, log=said), [])["log"]
        assert len(log) == lines + 1
        assert len(log[0]["text"]) == min(2000, len(text))
        assert "logged more" in log[-1]["text"]


def test_failing_moments_are_those_of_the_scenario() -> None:
    common = {"title": "T", "message": "m", "expected": "e", "actual": "a", "help": "h"}
    rows = [  # id, outcome, scenario, time
        ("late", "fail", "one", 3.0),
        ("early", "fail", "one", 1.0),
        ("passed", "pass", "one", 1.0),
        ("elsewhere", "fail", "two", 1.0),
        ("whenever", "fail", "one", None),
    ]
    names = ("id", "outcome", "scenario", "time")
    checks = [dict(zip(names, row, strict=True)) | common for row in rows]
    moments = moments_of(checks, "one")
    assert [moment["check"] for moment in moments] == ["early", "late"]
    assert moments[0] == {"t": 1.0, "check": "early", "outcome": "fail", **common}


def test_a_report_opens_at_the_failure_and_plays_from_the_keyboard(
    recording: Recording, open_file: Callable[..., Any], tmp_path: Path
) -> None:
    """The one of a report that `make test` opens in a browser; all others: tests/browser."""
    file = tmp_path / "report.html"
    file.write_text(page_html(page_payload(None, [recording], "A run")), "utf-8")
    page = open_file(file)
    assert page.locator("canvas.map").is_visible()
    page.keyboard.press("End")
    assert page.evaluate("window.replayPlayer.time") == pytest.approx(6.0)
    at_the_wall = page.evaluate("document.querySelector('canvas.map').toDataURL()")
    page.keyboard.press("Home")
    assert page.evaluate("window.replayPlayer.time") == 0.0
    assert page.evaluate("document.querySelector('canvas.map').toDataURL()") != at_the_wall
