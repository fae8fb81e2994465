"""docs/testing-your-node.md: its tests fail for wrong nodes; tests/journeys let them pass."""

import re
from pathlib import Path

import pytest

from grader.claims.mutants import find_mutant
from grader.course.exercises import ROOT, find_exercise
from rclpy_virtual_time.tests.testing.outside import pytest_in

PAGE = (ROOT / "docs/testing-your-node.md").read_text("utf-8")
DRIVEN = re.findall(r"(?ms)^```python\n(.*?)^```$", PAGE)[0]
KILLS = {  # as the page says
    "brakes_too_late": "test_stops_in_front_of_a_wall",
    "latched_stop": "test_drives_on_when_the_cart_has_passed",
    "two_twists_per_scan": "test_answers_each_scan_once",
}


@pytest.mark.long
def test_wrong_nodes_fail_the_test_that_the_page_names(tmp_path: Path) -> None:
    exercise = find_exercise("obstacle_avoidance")
    for mutant in KILLS:
        folder = tmp_path / mutant
        folder.mkdir()
        (folder / "my_agent.py").write_text(find_mutant(exercise, mutant).text, "utf-8")
        (folder / "test_agent.py").write_text(DRIVEN, "utf-8")
    session = pytest_in(tmp_path, "--import-mode=importlib")
    assert session.code == 1
    failed = {name for name, outcome in session.outcomes().items() if outcome == "failed"}
    assert failed == {f"{mutant}.test_agent.{test}" for mutant, test in KILLS.items()}
    assert len(session.tests) == 3 * len(KILLS)
    for test in KILLS.values():
        replay = tmp_path / ".course" / "replays" / f"test_agent-{test}.html"
        assert f"Replay: {replay}" in session.output
        page = replay.read_text("utf-8")
        assert f"<title>{test} failed" in page
    quoted = re.findall(r"(?m)^  nearest to an obstacle: .*$", PAGE)
    assert len(quoted) == 1
    assert quoted[0] in session.output


@pytest.mark.parametrize(
    ("name", "house"),
    [
        ("drive", "grader"),
        pytest.param("virtual_time", "rclpy_virtual_time", marks=pytest.mark.long),
    ],
)
def test_pytest_lists_the_fixtures(tmp_path: Path, name: str, house: str) -> None:
    session = pytest_in(tmp_path, "--fixtures")
    assert re.search(rf"(?m)^{name}\b.*{house}/testing/plugin\.py", session.output), session.output
