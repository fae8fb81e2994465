"""Two weeks of a class on a JupyterHub: each step with nbgrader's own commands, one who is late.

The layout is that of a hub whose servers run in containers: one exchange that all see, everybody is
the user `jovyan` there, and the hub says who it is (`JUPYTERHUB_USER`).
"""

from __future__ import annotations

import csv
import json
import os
import shutil
import subprocess
import sys
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

import pytest
from nbgrader_kit import (
    FULL,
    MadeOnce,
    cell_named,
    fill,
    make_course,
    mark_by_hand,
    nbgrader,
    solution,
)

COURSE = "rclpy_agents"
LOOP, GOAL, QUIZ = "01_loop", "03_goal", "quiz"
AGENTS = {
    LOOP: ("obstacle_avoidance", "obstacle_avoidance_agent.py"),
    GOAL: ("goal_seeking", "goal_seeking_agent.py"),
}
RULES = """
c.LatePenalty.per_day = 10
c.LatePenalty.grace_minutes = 60
c.ExchangeCollect.check_owner = False
"""
HIDDEN = "names perception, decision and action"  # of the quiz's mark scheme
ANSWER = "It perceives, decides and acts. BEGIN MARK SCHEME"
AS_JOVYAN = ["unshare", "--mount", "sh", "-c", 'mount --bind "$0" /etc/passwd && exec "$@"']


def can_mount() -> bool:
    if not shutil.which("unshare"):
        return False
    return not subprocess.run(
        [*AS_JOVYAN[:-1], "true"], check=False, capture_output=True
    ).returncode


pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not FULL, reason="two weeks of a class take two minutes: make notebooks"),
    pytest.mark.skipif(not can_mount(), reason="a hub's user names need a mount namespace: root"),
]


def as_student(course: Path, who: str, *arguments: str) -> None:
    """Run an nbgrader command in a student's server."""
    home = course / "homes" / who
    if not home.is_dir():
        home.mkdir(parents=True)
        (home / "nbgrader_config.py").write_text(
            f"c = get_config()\nc.CourseDirectory.course_id = {COURSE!r}\n"
            f"c.Exchange.root = {str(course / 'exchange')!r}\n"
            f"c.Exchange.cache = {str(home / '.cache')!r}\n",
            "utf-8",
        )
    passwd = home / "passwd"
    passwd.write_text(f"jovyan:x:{os.getuid()}:0::{home}:/bin/sh\n", "utf-8")
    done = subprocess.run(
        [*AS_JOVYAN, str(passwd), sys.executable, "-m", "nbgrader", *arguments],
        cwd=home, capture_output=True, text=True, check=False, timeout=300,
        env={**os.environ, "HOME": str(home), "JUPYTER_CONFIG_DIR": str(home / ".jupyter"),
             "JUPYTERHUB_USER": who},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-4000:]


def due(course: Path, assignment: str, when: datetime) -> None:
    """Set a due date as README does, in another zone than nbgrader's."""
    said = when.replace(microsecond=0).astimezone(timezone(timedelta(hours=5, minutes=30)))
    nbgrader(course, "db", "assignment", "add", assignment, f"--duedate={said.isoformat()}")


def hand_in(course: Path, who: str, assignment: str) -> None:
    as_student(course, who, "fetch_assignment", assignment)
    path = course / "homes" / who / assignment / f"{assignment}.ipynb"
    notebook = json.loads(path.read_text("utf-8"))
    if assignment == QUIZ:
        assert HIDDEN not in path.read_text("utf-8")
        cell_named(notebook, "quiz-1")["source"] = ANSWER
    else:
        slug, file = AGENTS[assignment]
        notebook = fill(notebook, {file: solution(slug, file)})
    path.write_text(json.dumps(notebook), "utf-8")
    as_student(course, who, "submit", assignment)


def two_weeks(course: Path) -> None:
    """Ann is late in the first week, ben in time; in the second week ann alone hands in."""
    make_course(course, [LOOP, GOAL, QUIZ], RULES)
    now = datetime.now(UTC)
    for assignment, late in ((LOOP, 1.5), (QUIZ, 0.5), (GOAL, -7)):
        due(course, assignment, now - timedelta(days=late))
        nbgrader(course, "release_assignment", assignment)
    for who, assignment in (("ann", LOOP), ("ben", LOOP), ("ann", GOAL), ("ann", QUIZ)):
        hand_in(course, who, assignment)
    in_time = (now - timedelta(days=1.5, minutes=-30)).strftime("%Y-%m-%d %H:%M:%S.0 UTC")
    (mine,) = (course / "exchange" / COURSE / "inbound").glob(f"ben+{LOOP}+*")
    (mine / "timestamp.txt").write_text(in_time, "utf-8")
    for assignment in (LOOP, GOAL, QUIZ):
        nbgrader(course, "collect", assignment)
        nbgrader(course, "autograde", assignment)
    mark_by_hand(course, ("ann", QUIZ, "quiz-1"), 3.0)
    for assignment in (LOOP, GOAL, QUIZ):
        nbgrader(course, "generate_feedback", assignment)
        nbgrader(course, "release_feedback", assignment)
        as_student(course, "ann", "fetch_feedback", assignment)
    nbgrader(course, "export")


@pytest.fixture(scope="module")
def course(made_once: MadeOnce) -> Path:
    return made_once("two-weeks", two_weeks)


@pytest.fixture(scope="module")
def exported(course: Path) -> dict[tuple[str, str], dict[str, str]]:
    with (course / "grades.csv").open(newline="") as file:
        return {(row["student_id"], row["assignment"]): row for row in csv.DictReader(file)}


@pytest.mark.parametrize(
    ("who", "assignment", "most", "raw", "penalty", "score"),
    [
        ("ann", LOOP, 100, 100, 20, 80),  # a day and a half late, less an hour
        ("ben", LOOP, 100, 100, 0, 100),  # within the hour of grace
        ("ann", GOAL, 100, 100, 0, 100),
        ("ann", QUIZ, 15, 3, 0.3, 2.7),  # marked by hand: its penalty comes with the feedback
    ],
)
def test_each_week_has_its_own_points_less_what_lateness_costs(
    exported: dict[tuple[str, str], dict[str, str]],
    who: str, assignment: str, most: float, raw: float, penalty: float, score: float,
) -> None:  # fmt: skip
    row = exported[who, assignment]
    columns = ("max_score", "raw_score", "late_submission_penalty", "score")
    assert [float(row[name]) for name in columns] == [most, raw, penalty, score]


def test_a_student_gets_the_feedback_but_not_the_mark_scheme(course: Path) -> None:
    pages = {path.stem: path.read_text("utf-8")
             for path in (course / "homes" / "ann").glob("*/feedback/*/*.html")}  # fmt: skip
    assert set(pages) == {LOOP, GOAL, QUIZ}
    assert "Late submission penalty (Score: -20.0)" in pages[LOOP]
    assert "Late submission penalty" not in pages[GOAL]
    assert ANSWER in pages[QUIZ]  # her own words stay, whatever they are
    assert HIDDEN not in pages[QUIZ]


def test_nothing_of_the_graders_is_in_the_exchange(course: Path) -> None:
    found = [path for path in (course / "exchange").rglob("*") if path.is_file()]
    assert {path.relative_to(course / "exchange" / COURSE).parts[0] for path in found} == {
        "outbound", "inbound", "feedback",
    }  # fmt: skip
    assert not [path for path in found if HIDDEN in path.read_text("utf-8", "replace")]
