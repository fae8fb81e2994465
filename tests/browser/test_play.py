"""The figures to play with say what the project's own simulation does."""

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grader.authoring.lesson_replays import LESSONS, LISTING
from grader.authoring.play_data import LIDARS, latencies, learned, made, scan
from grader.course.submission import find_submission
from grader.drive import arguments_of, drive_node, scenario_for
from rclpy_virtual_time.link.hosts import ForkServer
from sim.layout import Layout
from sim.lidar import PROFILES
from sim.robot import STEP, Robot
from sim.scenario import RobotSpec

Compute = Callable[..., dict[str, Any]]
FIGURES = ("beams", "executor", "knows", "queue", "stopping", "tail")
PERIODS = {"wide": 25, "default": 100, "lds01": 200}  # [ms] of a scan
QUEUES = [
    ("default", 200, 10), ("default", 200, 1), ("default", 200, 5), ("default", 230, 1),
    ("default", 230, 10), ("default", 40, 10), ("default", 150, 3), ("default", 310, 2),
    ("lds01", 300, 2), ("lds01", 110, 1), ("wide", 60, 4), ("wide", 80, 10),
]  # fmt: skip
BEATS = [
    (200, 1, 1), (200, 2, 1), (200, 1, 2), (200, 2, 2), (30, 1, 1), (40, 1, 1),
    (80, 1, 1), (130, 1, 1), (230, 1, 1), (370, 2, 1), (400, 2, 2), (90, 2, 2),
]  # fmt: skip
STOPS = [
    (0.5, 0.0, 0.9, 0.5), (0.5, 0.1, 0.9, 0.5), (0.5, 0.3, 0.9, 0.5), (0.15, 0.1, 0.9, 0.5),
    (0.5, 0.1, 0.4, 0.8), (1.0, 0.0, 0.9, 1.0), (1.0, 0.2, 2.0, 0.7), (0.3, 0.5, 0.3, 0.5),
    (0.1, 0.0, 2.0, 0.3), (0.75, 0.25, 1.5, 0.6), (0.2, 0.4, 1.0, 0.4), (0.6, 0.05, 0.6, 0.9),
]  # fmt: skip


@pytest.fixture(scope="module")
def compute(browser: Any) -> Iterator[Compute]:
    """What a figure says of settings."""
    page = browser.new_page()
    scripts = [LESSONS / "_static" / "play" / f"{name}.js" for name in ("kit", "data", *FIGURES)]
    page.set_content("<title>x</title>")
    for script in scripts:
        page.add_script_tag(content=script.read_text("utf-8"))
    yield lambda name, **settings: page.evaluate("(it) => play.compute(...it)", [name, settings])
    page.close()


def listing(name: str) -> str:
    """Return a program of the lesson."""
    for page in LESSONS.glob("*.md"):
        for found in LISTING.finditer(page.read_text("utf-8")):
            if found["file"] == name:
                return found["text"]
    raise LookupError(name)


def said(
    folder: Path, forkserver: ForkServer, name: str, text: str, lidar: str, *params: str
) -> list[str]:
    """Return what a program logs in 10 s, as `course drive` runs it."""
    file = folder / name
    file.write_text(text, "utf-8")
    scenario = scenario_for("demo_wall", lidar=lidar, duration=10.0)
    recording = drive_node(
        find_submission(file), scenario, forkserver, arguments=arguments_of(params)
    )
    return [line.text for line in recording.log if line.level == "info"]


def test_the_data_is_up_to_date() -> None:
    pytest.importorskip("sklearn", reason="scikit-learn is not installed")
    ((file, text),) = made()
    assert file.read_text("utf-8") == text, "run `python -m grader.authoring.play_data`"


@pytest.mark.parametrize(("lidar", "takes", "depth"), QUEUES)
def test_ages_are_those_of_a_drive(
    compute: Compute, forkserver: ForkServer, tmp_path: Path, lidar: str, takes: int, depth: int
) -> None:
    params = (f"depth:={depth}", f"takes:={takes / 1000}")
    lines = said(tmp_path, forkserver, "stale.py", listing("stale.py"), lidar, *params)
    driven = [[float(age) for age in re.findall(r"\d\.\d\d", line)] for line in lines]
    assert driven
    count = 10 * len(driven)
    drawn = compute("queue", period=PERIODS[lidar], takes=takes, depth=depth, count=count)
    ages = np.array([done["age"] for done in drawn["done"]]).reshape(-1, 10) / 1000
    assert np.allclose(driven, np.stack([ages.min(axis=1), ages.max(axis=1)], axis=1), atol=0.006)


@pytest.mark.parametrize(("takes", "threads", "groups"), BEATS)
def test_gaps_are_those_of_a_drive(
    compute: Compute, forkserver: ForkServer, tmp_path: Path, takes: int, threads: int, groups: int
) -> None:
    text = listing("beat.py").replace("time.sleep(0.2)", f"time.sleep({takes / 1000})")
    params = (f"threads:={threads}", f"separate:={str(groups > 1).lower()}")
    first = said(tmp_path, forkserver, "beat.py", text, "default", *params)[0]
    longest = compute("executor", takes=takes, threads=threads, groups=groups)["longest"]
    assert first == f"longest gap: {longest} ms"


@pytest.mark.parametrize(("speed", "late", "brake", "stop"), STOPS)
def test_ways_are_those_of_the_robot(
    compute: Compute, speed: float, late: float, brake: float, stop: float
) -> None:
    spec = RobotSpec(max_linear=speed, max_acceleration=brake)
    robot = Robot(spec, Layout((), (), (), (0.0, 0.0, 0.0)))
    while robot.v < speed - 1e-6:
        robot.step(0.0, speed, 0.0)
    begin = robot.pose[0]
    for _ in range(round(late / STEP)):
        robot.step(0.0, speed, 0.0)
    while robot.v > 1e-6:
        robot.step(0.0, 0.0, 0.0)
    told = compute("stopping", speed=speed, late=late, brake=brake, stop=stop)
    way = robot.pose[0] - begin
    assert told["way"] == pytest.approx(way, abs=speed * STEP)
    assert told["left"] == pytest.approx(stop - spec.radius - way, abs=speed * STEP)


@pytest.mark.parametrize("slice_", [(135, 225), (0, 90), (300, 359)])
@pytest.mark.parametrize("number", range(len(LIDARS)))
def test_slices_see_what_the_lidar_reads(
    compute: Compute, number: int, slice_: tuple[int, int]
) -> None:
    profile, mounted = list(LIDARS.values())[number]
    lidar, ranges = PROFILES[profile], scan(profile, mounted)
    usable = np.isfinite(ranges) & (ranges >= lidar.range_min)
    told = compute("beams", lidar=number, **{"from": slice_[0], "to": slice_[1]})
    part = slice(slice_[0], slice_[1] + 1)
    assert told["seen"] == pytest.approx(ranges[part][usable[part]].min(), abs=1e-6)
    angles = np.remainder(lidar.angles + mounted + np.pi, 2 * np.pi) - np.pi
    ahead = (np.abs(angles) <= np.pi / 4 + 1e-9) & usable
    assert told["truth"] == pytest.approx(ranges[ahead].min(), abs=1e-6)
    assert told["first"] == pytest.approx(np.degrees(angles[slice_[0]]), abs=1e-6)


def test_models_say_what_they_said(compute: Compute) -> None:
    pytest.importorskip("sklearn", reason="scikit-learn is not installed")
    forest, line = learned()
    for distance in (0.0, 0.2, 0.3, 0.32, 0.35, 0.4, 0.5, 0.6, 0.8, 1.0, 2.0, 12.0):
        told = compute("knows", distance=distance)
        row = np.array([[distance]])
        assert told["forest"] == pytest.approx(forest.predict(row)[0], abs=0.005)
        assert told["line"] == pytest.approx(line.predict(row)[0], abs=0.001)


@pytest.mark.parametrize("slow", [0, 1, 2, 3, 5, 6, 7, 9, 10, 12, 17, 20])
def test_percentiles_are_numpy_s(compute: Compute, slow: int) -> None:
    told = compute("tail", slow=slow, more=120)
    calls = np.array(told["calls"])
    assert np.count_nonzero(calls > 100) == told["late"] == slow
    assert np.sort(calls - 120 * (calls > 100)) == pytest.approx(np.sort(latencies()))
    assert told["mean"] == pytest.approx(calls.mean())
    shown = [told[name] for name in ("p50", "p95", "p99")]
    assert shown == pytest.approx(np.percentile(calls, [50, 95, 99]).tolist())
    if slow == 7:  # what the page's program prints
        page = (LESSONS / "real_time.md").read_text("utf-8")
        assert f"mean {told['mean']:.0f} ms, worst {calls.max():.0f} ms\n" in page
        for share in (50, 95, 99):
            assert f"\np{share} {told[f'p{share}']:.0f} ms\n" in page
