"""`drive` and `check` in a real kernel: what the judge says, with a bar on the way."""

import html
import json
import re
from pathlib import Path
from typing import Any

import pytest
from kernels import Kernel, Said, save

from grader.cli import cli
from grader.course.exercises import SOLUTIONS, find_exercise

AGENT = "obstacle_avoidance_agent.py"
RIGHT = (SOLUTIONS / "obstacle_avoidance" / AGENT).read_text("utf-8")
TOO_FAST = RIGHT.replace("STOP_DISTANCE = 0.5", "STOP_DISTANCE = 0.05")


def replays(said: Said) -> list[Any]:
    """Return the payloads of the replays below a cell."""
    pages = re.findall(r'<iframe class="course-replay" srcdoc="([^"]*)"', said.html)
    found = [re.search(r'id="payload">(.*?)</script>', html.unescape(page)) for page in pages]
    return [json.loads(payload[1]) for payload in found if payload is not None]


def unmeasured(text: str) -> list[str]:
    """Return the words of a summary, but for how long the machine took to compute."""
    times = r"\d[\d.]* ms (a message|\(p99\)|at worst)"
    return re.sub(times, r"… \1", " ".join(text.split())).split()


@pytest.mark.parametrize("at", [(), (4.2, 5.0)], ids=["plain", "looking"])
def test_drive_says_what_course_drive_says(
    at: tuple[float, ...],
    kernel: Kernel,
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    save(kernel, AGENT, RIGHT)
    said = kernel.run(f"drive('demo_wall', at={at}, callback={'tick' if at else ''!r})")
    monkeypatch.setenv("COLUMNS", "100")
    words = ["drive", str(folder / AGENT), "--scenario", "demo_wall"]
    words += [word for time in at for word in ("--at", str(time), "--callback", "tick")]
    cli.main(words, standalone_mode=False)
    expected = capsys.readouterr().out.replace(str(folder / AGENT), AGENT)
    expected = expected.replace("--log all shows them all", "the replay shows them all")
    assert unmeasured(said.text) == unmeasured(expected)
    assert ("distance in scan_callback" in said.text) == bool(at)
    assert ("tick: expected a function that had run by then" in said.text) == bool(at)
    assert said.stderr == ""
    (payload,) = replays(said)
    assert payload["grading"] is None
    assert payload["embedded"] is True
    assert [replay["scenario"] for replay in payload["replays"]] == ["demo_wall"]


def test_drive_takes_what_the_command_takes(kernel: Kernel, folder: Path) -> None:
    save(kernel, AGENT, RIGHT)
    (folder / "mine.toml").write_text('title = "Mine"\nworld = "hall"\nduration = 2.0\n')
    said = kernel.run(
        "drive('mine.toml', lidar='lds01', duration=1, seed=3, params={'use_sim_time': False})"
    )
    assert "in mine, seed 3" in said.text
    assert "/scan  sensor_msgs/msg/LaserScan  best_effort  5 messages (5.0 Hz)" in said.text
    assert "1.0 s simulated" in said.text


def test_the_last_cell_of_a_module_that_the_node_imports_leaves_the_node_the_last(
    kernel: Kernel, folder: Path
) -> None:
    save(kernel, AGENT, f"import os, my_limits\n{RIGHT}")
    save(kernel, "my_limits.py", "FASTEST = 0.3\n")
    assert f"{AGENT} in demo_wall\n" in kernel.run("drive('demo_wall', duration=1)").text


def test_a_right_solution_gets_all_points_in_the_terminals_words(
    kernel: Kernel,
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    save(kernel, AGENT, RIGHT)
    said = kernel.run("report = check('1:clear_zone, slow_zone')")
    monkeypatch.setenv("COLUMNS", "100")
    checks = ["--only", "clear_zone", "--only", "slow_zone"]
    cli.main(["grade", "1", str(folder / AGENT), *checks], standalone_mode=False)
    expected = capsys.readouterr().out.replace(str(folder / AGENT), AGENT)
    assert said.stderr == ""
    age, _, table = said.text.partition(" ago.\n")
    assert age.strip().startswith(f"{AGENT} was written ")
    assert table.split() == expected.partition("Next")[0].split()  # that is a command
    said = kernel.run("print(report.score, report.max_score, [c['id'] for c in report.checks])")
    assert said.stdout == "25 25 ['wiring', 'clear_zone', 'slow_zone']\n"
    again = kernel.run("report")  # is shown in another cell, too
    assert "Score  25 / 25" in again.text
    assert "course-check" in again.html


def test_a_failure_comes_with_its_replay_at_the_moment(kernel: Kernel) -> None:
    save(kernel, AGENT, TOO_FAST)
    said = kernel.run("report = check('obstacle_avoidance:stop_zone, sees_sides')")
    checks = json.loads(kernel.run("import json; print(json.dumps(report.checks))").stdout)

    failed = [check for check in checks if check["outcome"] == "fail"]
    assert failed[0]["id"] == "sees_sides"  # of the first task that fails
    (payload,) = replays(said)
    first = payload["replays"][0]
    assert first["scenario"] == failed[0]["scenario"]
    assert failed[0]["time"] in [moment["t"] for moment in first["moments"]]
    assert "<details open" in said.html
    for check in failed:
        for part in ("title", "message", "expected", "actual", "help"):
            assert html.escape(check[part]) in said.html


@pytest.mark.long
def test_a_changed_file_is_judged_anew_by_the_same_warm_judge(kernel: Kernel) -> None:
    save(kernel, AGENT, RIGHT)
    before = kernel.judge()
    assert "Score  10 / 10" in kernel.run("check('1:one_command_per_scan')").text
    save(kernel, AGENT, RIGHT.replace("self.cmd_vel_publisher.publish(twist)", "pass"))
    assert "Score  5 / 10" in kernel.run("check('1:one_command_per_scan')").text
    save(kernel, AGENT, RIGHT)
    assert "Score  10 / 10" in kernel.run("check('1:one_command_per_scan')").text
    assert kernel.judge() == before


@pytest.mark.long
def test_a_bar_shows_trials_and_checks_and_becomes_the_table(kernel: Kernel) -> None:
    save(kernel, AGENT, RIGHT)
    said = kernel.run("check()")
    assert len(said.displays) == 1  # the bar's place is the table's
    bars = [state["text/html"] for state in said.states if "progressbar" in state["text/html"]]
    assert len(bars) >= 2
    assert re.search(r"\d+ of \d+ runs", bars[-1])
    assert said.result is None  # shown once


def test_an_event_loop_and_plots_do_not_mind(kernel: Kernel) -> None:
    save(kernel, AGENT, RIGHT)
    said = kernel.run(
        "%matplotlib inline\nimport asyncio\nawait asyncio.sleep(0)\n"
        "async def inside():\n    return check('1:wiring')\n"
        "print((await inside()).score, asyncio.get_running_loop().is_running())"
    )
    assert said.traceback == ""
    assert said.stdout == "5 True\n"


@pytest.mark.long
def test_two_files_of_an_exercise_go_together(kernel: Kernel, folder: Path) -> None:
    exercise = find_exercise("model_server")
    for name in exercise.files:
        save(kernel, name, (exercise.solutions / name).read_text("utf-8"))
    said = kernel.run("report = check('6')")
    assert kernel.run("print(report.score == report.max_score)").stdout == "True\n", said.text
    said = kernel.run("drive('detect_together')")
    assert "detection_server.py in detect_together" in said.text
    assert "client /detect" in said.text
