"""nbgrader's weeks on a JupyterHub, by the README's lines, with due dates in a zone; one is late.

The layout is that of a hub whose servers run in containers: one exchange that all see, everybody is
the user `jovyan` there, and the hub says who it is (`JUPYTERHUB_USER`).
"""

import csv
import json
import os
import re
from collections.abc import Callable
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

import pytest
from person import ROOT, Person, can_mount

README = (ROOT / "notebooks" / "README.md").read_text("utf-8")
TYPED = {  # what it does: the README's first line that does it
    name: line for line, name in reversed(re.findall(r"(?m)^    (nbgrader (\w+)\b.*)$", README))
}
RULES = """
c.LatePenalty.per_day = 10
c.LatePenalty.grace_minutes = 60
c.ExchangeCollect.check_owner = False
"""
LOOP, QUIZ, FILE = "01_loop", "quiz", "obstacle_avoidance_agent.py"
SOLUTION = (ROOT / "solutions" / "obstacle_avoidance" / FILE).read_text("utf-8")
HIDDEN = "names perception, decision and action"  # of the quiz's mark scheme
ANSWER = "It perceives, decides and acts. BEGIN MARK SCHEME"
# a person gives 3 points for the quiz's first answer; the penalty comes with the feedback
MARKS = """
from nbgrader.api import Gradebook
with Gradebook("sqlite:///gradebook.db") as book:
    for n in range(1, 6):
        grade = book.find_grade(f"quiz-{n}", "quiz", "quiz", "ann")
        grade.manual_score, grade.needs_manual_grade = 3.0 * (n == 1), False
    book.db.commit()
"""
WANTED = {  # most, raw, penalty, score
    ("ann", LOOP): [100, 100, 20, 80],
    ("ben", LOOP): [100, 100, 0, 100],
}
LATE = {LOOP: 1.5}  # ann, in days
if os.environ.get("COURSE_NOTEBOOKS") == "full":  # make notebooks
    WANTED["ann", QUIZ] = [15, 3, 0.3, 2.7]
    LATE[QUIZ] = 0.5
KOLKATA = timezone(timedelta(hours=5, minutes=30))

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not can_mount(), reason="a hub's user names need a mount namespace: root"),
]


def student(hub: Path, who: str) -> Callable[[str], str]:
    """Return what types a line in a student's server."""
    person = Person(hub / who, hub / "env")
    person.writes({
        "nbgrader_config.py": "c = get_config()\nc.CourseDirectory.course_id = 'rclpy_agents'\n"
        f"c.Exchange.root = {str(hub / 'exchange')!r}\n",
        "passwd": f"jovyan:x:{os.getuid()}:0::{person.home}:/bin/sh\n",
    })  # fmt: skip
    as_jovyan = f"mount --bind passwd /etc/passwd && export JUPYTERHUB_USER={who} && "
    return lambda line: person.types(as_jovyan + line, before="unshare --mount")


def works(hub: Path, who: str, assignment: str) -> None:
    types = student(hub, who)
    types(f"nbgrader fetch_assignment {assignment}")
    path = hub / who / assignment / f"{assignment}.ipynb"
    assert HIDDEN not in path.read_text("utf-8")
    notebook = json.loads(path.read_text("utf-8"))
    for cell in notebook["cells"]:
        if cell["metadata"].get("nbgrader", {}).get("grade_id") == "quiz-1":
            cell["source"] = ANSWER
        if "".join(cell["source"]).startswith(f"%%node {FILE}\n"):
            cell["source"] = f"%%node {FILE}\n{SOLUTION}"
    path.write_text(json.dumps(notebook), "utf-8")
    types(f"nbgrader submit {assignment}")


def test_from_release_to_feedback(instructors: Path, tmp_path: Path) -> None:
    """Ann is late, and ben within the hour of grace."""
    instructor = Person(instructors, instructors.parent.parent / "env")
    hub, course = tmp_path, instructors
    (hub / "env").symlink_to(instructor.environment)
    (hub / "exchange").mkdir()
    (hub / "exchange").chmod(0o777)
    with (course / "nbgrader_config.py").open("a") as config:
        config.write(f"{RULES}c.Exchange.root = {str(hub / 'exchange')!r}\n")

    def does(what: str) -> None:
        for assignment in LATE:
            instructor.types(TYPED[what].replace(LOOP, assignment))

    does("generate_assignment")
    now = datetime.now(UTC).replace(microsecond=0)
    for assignment, late in LATE.items():
        due = (now - timedelta(days=late)).astimezone(KOLKATA).isoformat()
        line = re.sub(r"(?<=--duedate=)\S+", due, TYPED["db"]).replace(LOOP, assignment)
        assert due in line
        instructor.types(line)
    does("release_assignment")
    for who, assignment in WANTED:
        works(hub, who, assignment)
    in_time = (now - timedelta(days=1.5, minutes=-30)).strftime("%Y-%m-%d %H:%M:%S.0 UTC")
    (mine,) = (hub / "exchange").glob(f"*/inbound/ben+{LOOP}+*/timestamp.txt")
    mine.write_text(in_time, "utf-8")
    does("collect")
    does("autograde")
    if QUIZ in LATE:
        instructor.types(f"python -c '{MARKS}'")
    does("generate_feedback")
    does("release_feedback")
    for assignment in LATE:
        student(hub, "ann")(f"nbgrader fetch_feedback {assignment}")
    instructor.types(TYPED["export"])

    with (course / "grades.csv").open(newline="") as file:
        rows = {(row["student_id"], row["assignment"]): row for row in csv.DictReader(file)}
    columns = ("max_score", "raw_score", "late_submission_penalty", "score")
    found = {key: [float(rows[key][name]) for name in columns] for key in WANTED}
    assert found == WANTED
    pages = {path.stem: path.read_text("utf-8")
             for path in (hub / "ann").glob("*/feedback/*/*.html")}  # fmt: skip
    assert set(pages) == {*LATE}
    assert "Late submission penalty (Score: -20.0)" in pages[LOOP]
    there = [path for path in (hub / "exchange").rglob("*") if path.is_file()]
    assert {path.relative_to(hub / "exchange").parts[1] for path in there} == {
        "outbound", "inbound", "feedback",
    }  # fmt: skip
    assert not [path for path in there if HIDDEN in path.read_text("utf-8", "replace")]
    if QUIZ in LATE:  # her own words stay, whatever they are
        assert (ANSWER in pages[QUIZ], HIDDEN in pages[QUIZ]) == (True, False)
