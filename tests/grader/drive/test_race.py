"""Races: figures of recordings that were made by hand, the table of a class, the command."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from driven import drive_by

from grader import cli
from grader.authoring.ghosts import ghosts_of
from grader.course.exercises import all_exercises, find_exercise
from grader.drive.race import GHOSTS, lap_of, loss_to, reference_laps, too_near, track_of
from grader.drive.standings import class_rows, read_result, standings
from grader.exercises import contract_of
from grader.recording import Outcome, Recording
from rclpy_virtual_time.link.hosts import ForkServer
from sim.messages import pose_stamped
from sim.scenario_files import load_scenario
from sim.simulation import Truth
from workspace.build import course_files

FIRST, THIRD = find_exercise("1"), find_exercise("3")
RACING = [each for each in all_exercises() if contract_of(each).race]
REFERENCE = FIRST.solutions / FIRST.files[0]
SHIPPED = json.loads(GHOSTS.read_text("utf-8"))
STEP = 20_000_000  # [ns] from one sample of the truth to the next
TOUCHED = "touched something at 1.0 s"


def made(world: str, speed: float = 0.1, goal: tuple[float, float] | None = None) -> Recording:
    """Return a recording with five samples of the truth; a goal is sent at the second."""
    truth = Truth(
        t=np.arange(5) * STEP, x=np.array([0.0, 0.1, 0.3, 0.3, 0.3]), y=np.zeros(5),
        yaw=np.zeros(5), v=np.array([0.0, 0.01, 0.03, 0.03, 0.01]),
        w=np.array([0.0, 0.0, 0.02, 0.02, 0.02]), contact=np.zeros(5, dtype=bool),
        clearance=np.full(5, 10.0) if goal else np.array([1.0, 0.5, 0.4, 0.3, 0.8]),
    )  # fmt: skip
    sent = (pose_stamped(time=STEP, x=goal[0], y=goal[1]),) if goal else ()
    drive = drive_by(lambda scan: speed, load_scenario(world))
    return replace(drive, truth=truth, delivered=sent)


def test_figures_are_those_that_one_computes_by_hand() -> None:
    lap = lap_of(made("avoid_cart"), contract_of(FIRST))
    assert (lap.figure, lap.nearest, lap.median, lap.ended) == (0.3, 0.3, 0.5, "")
    assert too_near(lap, contract_of(FIRST)) == ""
    near = msgspec.structs.replace(lap, nearest=0.19)
    assert too_near(near, contract_of(FIRST)).startswith("finished, though 0.19 m is less than")
    assert lap.acceleration == 0.75  # of 0.5, 1, 0 and -1 m/s²: the root of 2.25 / 4
    assert lap.turning == 0.5  # of 0, 1, 0 and 0 rad/s²
    lap = lap_of(made("goal_behind", goal=(0.8, 0.0)), contract_of(THIRD))
    assert (lap.figure, lap.nearest, lap.median) == (0.02, None, None)  # 0.5 m at the third
    lap = lap_of(made("goal_behind", goal=(0.8, 0.1)), contract_of(THIRD))
    assert (lap.figure, lap.ended) == (None, "did not come to its goal")


def test_who_touches_something_dies_or_breaks_a_limit_has_no_figure() -> None:
    right = made("avoid_cart")
    touching = replace(right, truth=replace(right.truth, contact=np.arange(5) > 2))
    dead = replace(right, outcome=Outcome("exception", "No\x1b[2J\nerror", 3.0))
    for recording, said in (
        (touching, "touched something at 0.1 s"), (dead, "dies: No at 3.0 s"),
        (made("avoid_cart", speed=0.6), "asks for 0.60 m/s at 0.0 s"),
    ):  # fmt: skip
        lap = lap_of(recording, contract_of(FIRST))
        assert (lap.figure, lap.ended, lap.nearest) == (None, said, 0.3)


def test_where_a_drive_loses_is_said_in_the_seconds_of_its_run() -> None:
    t = np.arange(0, 501) * STEP  # 10 s
    halts = 0.3 * (t / 1e9 - np.clip(t / 1e9 - 4.0, 0.0, 3.0))  # [m] it stands from 4 to 7 s

    def drive(x: Any, world: str, goal: tuple[float, float] | None) -> Recording:
        flat, right = np.zeros(len(t)), made(world, goal=goal)
        truth = replace(right.truth, t=t, x=x, y=flat, yaw=flat)
        return replace(right, truth=truth)

    for exercise, world, goal, lost in (
        (FIRST, "avoid_cart", None, "of 0.9 m"), (THIRD, "goal_behind", (2.5, 0.0), "3.0 of 3.0 s"),
    ):  # fmt: skip
        slow, contract = drive(halts, world, goal), contract_of(exercise)
        fast = drive(0.3 * t / 1e9, world, goal)
        said = loss_to("the reference", track_of(fast), slow, contract)
        assert said.endswith(f"{lost} to the reference"), said
        since, until = (float(said.split()[i]) for i in (1, 3))
        assert 3.7 < since < until < 7.3, said
        assert loss_to("the reference", track_of(slow), fast, contract) == ""


@pytest.mark.parametrize("exercise", RACING, ids=lambda exercise: exercise.slug)
def test_the_ghosts_that_are_handed_out_are_the_references(
    forkserver: ForkServer, exercise: Any
) -> None:
    shipped, driven = SHIPPED[exercise.slug], ghosts_of(exercise, forkserver)
    assert list(shipped) == list(driven) == list(contract_of(exercise).race)
    for world, each in driven.items():
        assert shipped[world]["lap"] | {"recording": ""} == each["lap"] | {"recording": ""}
        assert shipped[world]["track"].keys() == {"t", "x", "y", "yaw"}  # and nothing of the node
        for column, numbers in shipped[world]["track"].items():
            assert numbers == pytest.approx(each["track"][column], abs=0.011), world
    assert len(GHOSTS.read_bytes()) < 30_000
    assert "grader/drive/ghosts.json" not in course_files()  # the page has it as race.json


# --- a class -------------------------------------------------------------------------------------


def result(name: str, *figures: float | None) -> dict[str, Any]:
    """Return what a file says of a race like the reference's, with other figures."""
    laps = [dict(each["lap"]) for each in SHIPPED[FIRST.slug].values()]
    for lap, figure in zip(laps, figures or (4.0, 5.0, 3.0), strict=True):
        lap |= {"figure": figure, "ended": TOUCHED if figure is None else ""}
    return {"course": "1.0.0", "exercise": FIRST.slug, "nickname": name, "laps": laps}


def hostile() -> dict[str, bytes]:
    """Return contents that are no results, by what is wrong with them."""
    good = result("x")

    def but(**changes: Any) -> bytes:
        return json.dumps(good | changes).encode()

    def lap(**changes: Any) -> bytes:
        return but(laps=[good["laps"][0] | changes, *good["laps"][1:]])

    return {
        "bytes": b"\xff\xfe\x00{", "deep": b"[" * 9_000, "null": b"null", "empty": b"",
        "long": but() + b" " * 10_000, "more": but(grade=100), "two": but(laps=good["laps"][1:]),
        "other": but(exercise="../goal_seeking"), "nobody": but(nickname="\u202e\x1b[2J "),
        "endless": but(nickname="x" * 25), "nan": lap(figure=float("nan")), "text": lap(figure="4"),
        "negative": lap(figure=-1.0), "huge": lap(figure=1e300), "neither": lap(figure=None),
        "other world": lap(of="0" * 64), "no digest": lap(recording="x" * 64),
        "another": lap(world="avoid_wall"), "fast": lap(figure=99.9),
        "none": json.dumps(result("x", None, None, None)).encode(),
    }  # fmt: skip


def test_a_class_is_ranked_and_what_is_no_result_is_left_out_by_name(tmp_path: Path) -> None:
    good = {
        "ada": result("Ada", 4.5, 5.5, 3.5), "b/ada": result(" ada ", 4.0, 5.0, 3.0),
        "bob": result("=cmd()|B\x1b[31mob", 9.0, 9.0, None), "c": result("Cyd", 4.5, 5.5, 3.5),
    }  # fmt: skip
    contents = {name: json.dumps(content).encode() for name, content in good.items()} | hostile()
    (tmp_path / "b").mkdir()
    for name, data in contents.items():
        (tmp_path / f"{name}.json").write_bytes(data)
    (tmp_path / "link.json").symlink_to(tmp_path / "ada.json")
    (tmp_path / "folder.json").mkdir()
    (tmp_path / "b" / "photo.png").touch()
    found, said = standings(tmp_path)
    rows = class_rows(FIRST, found[FIRST.slug])
    assert [row[:2] for row in rows[1:]] == [["1.", "Ada"], ["1.", "Cyd"], ["3.", "=cmd()|Bob"]]
    assert rows[3][2:] == ["2 of 3", "9.00", "9.00", "-", "18.00", "0.30", "0.57"]
    two = "2 results by one nickname, for neither case nor blanks count"
    assert said.pop() == f"Ada: {two}: ada.json (by “Ada”), b/ada.json (by “ada”); ada.json counts"
    left = {f"{name}.json" for name in (*hostile(), "link", "folder")} | {"b/photo.png"}
    assert {line.partition(": left out: ")[0] for line in said} == left
    assert all("\x1b" not in line and "\n" not in line for line in said)
    table = tmp_path / "table.csv"
    assert cli.run(["race", "--table", str(tmp_path), "--csv", str(table)]) == 0
    written = list(csv.reader(table.read_text("utf-8-sig").splitlines()))
    assert [row[2] for row in written] == ["nickname", "Ada", "Cyd", "'=cmd()|Bob"]
    assert written[0][1] == "by the worlds finished, then the greatest sum"


# --- the command ---------------------------------------------------------------------------------


@pytest.fixture
def race(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str]]:
    def race(*words: object) -> tuple[int, str]:
        code = cli.run(["race", *map(str, words)])
        return code, "".join(capsys.readouterr())

    return race


def test_a_race_through_the_command(race: Callable[..., tuple[int, str]], tmp_path: Path) -> None:
    node, out, report = (tmp_path / name for name in (FIRST.files[0], "race.json", "race.html"))
    text = REFERENCE.read_text("utf-8")
    node.write_text(text, "utf-8")
    code, said = race(node, "--report", report)
    assert (code, {path.name for path in tmp_path.iterdir()}) == (0, {node.name, report.name})
    assert '"ghosts":[{"name":"reference","t":[0.0,0.2' in report.read_text("utf-8")
    rows = [line.split() for line in said.splitlines() if line.startswith("  ")]
    assert [row[1:] for row in rows if row[0] == "yours"] == [
        row[1:] for row in rows if row[0] == "reference"
    ]
    named = (1, node, "--nickname", "Ada", "--out", out)
    assert race(*named)[0] == 0
    for lap in read_result(out).laps:
        reference, _ = reference_laps(FIRST.slug)[lap.world]
        assert msgspec.structs.replace(reference, recording=lap.recording) == lap
    assert text.count("return SLOW_SPEED") == 1
    node.write_text(text.replace("return SLOW_SPEED", "return FULL_SPEED / 2"), "utf-8")
    said = race(*named)[1]
    assert "your best" in said
    kept = Path("".join(said.partition("go back to: ")[2].split()))
    assert kept.read_bytes() == node.read_bytes()
    faster = read_result(out)
    node.write_text(text, "utf-8")
    assert "has your best, and stays as it is" in race(*named)[1]
    assert str(kept) not in race(1, node, "--nickname", "Bob", "--out", tmp_path / "b.json")[1]
    assert kept.read_bytes() != node.read_bytes()
    code, said = race(1, node, "--nickname", "Bob", "--out", out)
    assert (code, read_result(out)) == (2, faster)
    assert "another's result" in said
    node.write_text(text.replace("return SLOW_SPEED", "return 9.9"), "utf-8")
    none = out.with_name("none.json")
    assert "no world was finished" in race(1, node, "--nickname", "Bob", "--out", none)[1]
    assert not none.exists()


def test_wrong_usage_is_refused(race: Callable[..., tuple[int, str]]) -> None:
    for words, said in (
        ((), "expected the file of a node"), ((2, REFERENCE), "exercise 2 has no race"),
        ((REFERENCE, "--out", "race.json"), "expected a --nickname"),
        ((REFERENCE, "--table", "x"), "nothing to race"),
        ((REFERENCE, "--nickname", "\x1b[2J"), "visible characters"),
        (("--table", "no_such_folder"), "expected a folder with results"),
    ):  # fmt: skip
        code, printed = race(*words)
        assert (code, said in printed) == (2, True), printed
