"""Others' ways: two right solutions that differ much, and figures of real runs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from grader.authoring.ways import ways_of
from grader.claims.claims import claim_of, grade_claim
from grader.course.exercises import find_exercise
from grader.launchers import launcher_pool


@pytest.mark.long
def test_two_ways_have_all_points_and_are_told_apart(tmp_path: Path) -> None:
    with launcher_pool(most=1) as servers:
        one, other = ways_of(find_exercise("3"), servers)
        [(name, text)] = other["files"].items()
        (tmp_path / name).write_text(text, "utf-8")
        claim = claim_of(find_exercise("3"), "variant", tmp_path / name)
        assert grade_claim(claim, servers.of(), field=False).whole
    assert one["about"].startswith("Functions and closures, no class")
    assert "lines of code; the reference has" in one["said"][1]
    assert "ms of CPU" in one["said"][2]
    assert "sends other messages than the reference (goal_" in one["said"][3]
    assert one["said"][-1].startswith("It passes all 5 field checks")
    saved = r"it saves \d+ lines.* It costs .*\d s on its ways, 2 field checks\."
    assert re.search(saved, other["said"][0])
    assert "stands still until the goal is ahead" in other["about"]
    assert any(said.startswith("goal_behind: ") for said in other["said"])
    assert other["said"][-1].startswith("Of 5 field checks it fails 2: Hears an odometry driver")
    assert "field:" not in text  # what the proof reads
