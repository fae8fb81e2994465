"""`course autograde` as it is typed: what it takes in, its exit code, and one small class."""

from pathlib import Path

from command_line import course

from grader.course.exercises import find_exercise

AGENT = "obstacle_avoidance_agent.py"
(LIVE,) = find_exercise("live_parameters").files
ROSTER = 'Student,ID,SIS Login ID,Section\n"Lee, Carla",12345,clee,A\n"Ray, Bo",2,b,B\n'


def look(*arguments: object) -> tuple[int, str]:
    done = course("autograde", *arguments, COLUMNS="200")
    assert "Traceback" not in done.err
    return done.code, done.out + done.err


def test_a_look_at_what_was_handed_in(tmp_path: Path) -> None:
    week = tmp_path / "week"
    week.mkdir()
    for file in (AGENT, LIVE):
        (week / f"leecarla_12345_678901_{file}").write_text("print('mine')\n")
    roster = tmp_path / "class.csv"
    roster.write_text(ROSTER)
    code, said = look(week, "--roster", roster, "--list")
    assert code == 0
    assert "Carla Lee (A): obstacle_avoidance" in said
    assert "Bo Ray (B): nothing handed in" in said
    counts = "2 students; to be graded: 1 student, 2 files; nothing handed in: 1 student."
    assert counts in said
    assert sorted(path.name for path in tmp_path.iterdir()) == ["class.csv", "week"]

    (week / "\x1b[31mevil.docx").write_text("nobody's\n")
    code, said = look(week, "--list")
    assert code == 1
    assert "not understood" in said
    assert "a file of nobody's" in said
    assert "\x1b" not in said


def test_wrong_usage(tmp_path: Path) -> None:
    assert look(tmp_path)[0] == 2
    code, said = look(tmp_path, "--list", "--column", "1")
    assert code == 2
    assert "expected EXERCISE=TITLE" in said
    code, said = look(tmp_path, "--out", tmp_path / "out", "--regrade", "--again", "ann")
    assert code == 2
    assert "expected one of them" in said
    code, said = look(tmp_path / "nowhere.zip", "--list")
    assert code == 2
    assert "nowhere.zip: expected what the class has handed in; nothing is there" in said
