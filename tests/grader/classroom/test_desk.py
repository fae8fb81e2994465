"""`course desk`, over its HTTP: what is done there is what the commands do, and nobody else can."""

import html as html_
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from desk_client import Forms, Visitor, open_desk, words
from fake_class import FILE, SLUG
from marked_class import payload, points
from test_whole_class import folder_of, judge, moodles, namesakes

from grader.classroom.amendments.change import Comment, Style, Undo
from grader.classroom.amendments.log import described
from grader.classroom.desk import asked
from grader.classroom.desk.forms import Form
from grader.classroom.desk.marking import marking, reading
from grader.classroom.folder import UNWRITTEN
from grader.classroom.queue.store import Store
from grader.errors import InputError

Desk = Callable[[Path], tuple[Visitor, Visitor]]
ANN = f"/student/ann/{SLUG}"
ASKED = f"""Dear all,
> Student: ann
> Exercise: {SLUG}
> Check: slow_zone
> Moment: 2.1 s
> Please look at: the robot <b>was</b>\u202e right,
> I think.
"""


@pytest.fixture
def desk(graded: Path) -> Iterator[tuple[Visitor, Visitor]]:
    """Two assistants at the desk of a class where everybody has 70 of 100, and eve is held."""
    (graded / asked.RUBRIC).write_text('[points]\n"Names" = 4\n"Parts & order" = 2\n')
    with open_desk(graded, "Ada", "Ben") as addresses:
        yield Visitor(addresses["Ada"]), Visitor(addresses["Ben"])


def log_of(out: Path) -> list[tuple[str, str, str]]:
    with reading(out) as class_:
        return [(each.who, described(each.change), each.why) for each in class_.entries]


def test_a_mark_is_shown_then_written_and_a_stale_one_is_refused(
    desk: tuple[Visitor, Visitor], graded: Path
) -> None:
    ada, ben = desk
    theirs = ben.page(ANN)
    shown = ben.send(theirs, {"kind": "score"}, points="10", why="x")
    preview = ada.send(ada.page(ANN), {"kind": "score"}, points="85", why="by <mail>")
    assert f"ann {SLUG} 70 → 85" in html_.unescape(words(preview))
    assert log_of(graded) == [] and points(graded)["ann"] == "70"
    ada.send(preview, {"sure": "1"})
    assert ada.sent(preview, {"sure": "1"})[0] == 409  # sent twice
    assert log_of(graded) == [("Ada", f"{SLUG}: 85 points (ann)", "by <mail>")]
    assert points(graded)["ann"] == "85"
    for page, fields in (
        (shown, {"sure": "1"}),
        (theirs, {"kind": "score"}),
        (theirs, {"kind": "comment"}),
    ):
        status, _, said = ben.sent(page, fields, points="10", why="x", line="1", words="my words")
        assert status == 409
        assert "Entry 1, Ada" in words(said)
    assert "my words" in said
    assert len(log_of(graded)) == 1
    # another student's marks are no reason to refuse
    bobs = ben.page(f"/student/bob/{SLUG}")
    ada.send(ada.send(ada.page(ANN), {"kind": "score"}, points="90", why="x"), {"sure": "1"})
    ben.send(ben.send(bobs, {"kind": "score"}, points="60", why="x"), {"sure": "1"})
    assert points(graded) == {"ann": "90", "bob": "60", "eve": ""}


def test_who_writes_at_the_same_time_waits(desk: tuple[Visitor, Visitor], graded: Path) -> None:
    theirs = [
        (each, each.page(f"/student/{student}/{SLUG}"))
        for each, student in zip(desk, ("ann", "bob"), strict=True)
    ]
    with ThreadPoolExecutor() as pool:
        sent = [
            pool.submit(each.sent, page, {"kind": "comment"}, line="1", words="x")
            for each, page in theirs
        ]
    assert [each.result()[0] for each in sent] == [200, 200]
    assert sorted(who for who, _, _ in log_of(graded)) == ["Ada", "Ben"]


def test_several_at_once_and_the_log(desk: tuple[Visitor, Visitor], graded: Path) -> None:
    ada, _ = desk

    def make(kind: str, wanted: dict[str, str], **typed: Any) -> str:
        page = ada.page("/marks")
        shown = ada.send(page, wanted, why="agreed", **({} if "kind" in wanted else {"kind": kind}),
                         **typed)  # fmt: skip
        return words(ada.send(shown, {"sure": "1"}))

    said = make("waive", {"exercise": SLUG}, check="slow_zone", who="all")
    assert "2 scores changed" in said or "3 scores changed" in said
    make("late", {"kind": "late"}, who="students", student="ann\nbob", deadline="2026-05-04T23:59",
         zone="UTC", per_day="10", grace="0", cap="50")  # fmt: skip
    times = "id;time\r\nann;2026-05-06 23:00\r\n"
    make("late", {"kind": "late"}, who="all", deadline="2026-05-04T23:59", zone="UTC",
         per_day="10", grace="0", cap="", times=times)  # fmt: skip
    assert points(graded) == {"ann": "80", "bob": "100", "eve": "100"}
    make("undo", {"kind": "undo", "entry": "3"})
    make("publish", {"kind": "publish"}, who="students", student="ann")
    assert (graded / "published/ann/index.html").is_file()
    make("undo", {"kind": "undo", "entry": "1"})
    assert [what for _, what, _ in log_of(graded)] == [
        f"{SLUG}: slow_zone does not count (everybody)",
        f"{SLUG}: after 2026-05-04T23:59:00+00:00, 10 % of the points a day, at most 50 % "
        "(ann, bob)",
        f"{SLUG}: after 2026-05-04T23:59:00+00:00, 10 % of the points a day, times of a file for 1 "
        "(everybody)",
        "entry 3 is undone", "feedback published: all exercises (ann)", "entry 1 is undone",
    ]  # fmt: skip
    assert "undone by 6" in words(ada.page("/marks"))
    status, _, said = ada.sent(ada.page("/marks"), {"exercise": SLUG}, kind="set", who="all",
                               check="blind", points="500", why="x")  # fmt: skip
    assert status == 400 and "gives 0 to" in said


def test_what_a_kill_has_left_is_written(desk: tuple[Visitor, Visitor], graded: Path) -> None:
    ada, _ = desk
    assert "Write all results" not in ada.page("/")
    (graded / "scores.csv").unlink()
    with Store(graded / "store.sqlite") as store:
        store.keep(UNWRITTEN, "yes")
    said = words(ada.send(ada.page(ANN), {"kind": "write"}))
    assert "All results" in said and "Write all results" not in said
    assert points(graded)["ann"] == "70" and log_of(graded) == []


def test_a_file_of_times_may_be_any_spreadsheets() -> None:
    form = Form.of({"zone": [b"UTC"]}, {"times": [{"body": "id;Zoë\r\n".encode("cp1252")}]})
    assert form["times"] == "id;Zoë"


def test_words_for_the_student(desk: tuple[Visitor, Visitor], graded: Path) -> None:
    ada, _ = desk
    ada.send(ada.page(ANN), {"kind": "comment"}, line="1", words="Why\nthis? </script>")
    ada.send(ada.page(ANN), {"kind": "style"}, points=["3", "1.5"])
    ada.send(ada.page("/requests"), {"kind": "request"}, text=ASKED)
    page = ada.page("/requests")
    asks = "the robot &lt;b&gt;was&lt;/b&gt; right, I think."
    assert asks in page and asks in ada.page(ANN) and "Requests (1)" in page
    assert ada.sent(page, {"kind": "request"}, text=ASKED)[0] == 400  # in the log already
    ada.send(page, {"kind": "answer"}, words="Looked at: it was not.")
    assert "Requests (0)" in ada.page("/")
    with marking(graded) as class_:  # as the commands make them
        changes = [each.change for each in class_.entries]
        assert changes[0] == asked.comment(class_, "ann", "1", FILE, 1, "Why this? </script>")
        assert changes[1] == asked.style(class_, "ann", "1", {"Names": 3, "Parts & order": 1.5})
        assert isinstance(changes[0], Comment) and isinstance(changes[1], Style)
        assert changes[3] == asked.answer(class_, 3, "Looked at: it was not.")
    notes = payload(graded / f"feedback/ann/{SLUG}.html")["grading"]["notes"]
    assert notes == [
        f"{FILE}, line 1: Why this? </script>",
        "Beside these points: style 4.5 of 6 (Names 3 of 4; Parts & order 1.5 of 2).",
        "Answer to your request: Looked at: it was not.",
    ]
    assert points(graded)["ann"] == "70"
    with marking(graded) as class_:
        class_.add(Undo(1), "Ada", "a slip")
    assert "Why this?" not in (graded / f"feedback/ann/{SLUG}.html").read_text()


def test_who_is_not_at_the_desk_changes_nothing(
    desk: tuple[Visitor, Visitor], graded: Path
) -> None:
    ada, ben = desk
    port = ada.host.rpartition(":")[2]
    assert "HttpOnly" in ada.set_cookie and "SameSite=Strict" in ada.set_cookie
    for headers in (
        {"Host": f"evil.example:{port}"},  # DNS rebinding
        {"Host": f"127.0.0.1.evil.example:{port}"},
        {"Cookie": None},
        {"Cookie": ada.cookie[:-1]},
        {"Sec_Fetch_Site": "cross-site"},
        {"Sec_Fetch_Site": "same-site"},  # another port of this machine
    ):
        for path in ("/", ANN, f"/replay/ann/{SLUG}", "/change"):
            status, _, said = ada.ask("GET", path, **headers)
            assert status == 403 and "ann" not in words(said), (headers, path)
    page = ada.page(ANN)
    typed = {"points": "1", "why": "x", "sure": "1"}
    for form, headers in (
        (page, {"Origin": "http://evil.example"}),
        (page, {"Origin": "null"}),
        (page, {"Origin": "http://127.0.0.1:1"}),
        (page, {"Origin": None}),
        (page, {"Sec_Fetch_Site": "same-site"}),
        (ben.page(ANN), {}),  # another one's form
    ):
        form_fields = dict(
            next(each for each in Forms(form).forms if dict(each).get("kind") == "score")
        )
        body = "&".join(f"{k}={v}" for k, v in {**form_fields, **typed}.items())
        assert ada.ask("POST", "/change", body, **headers)[0] == 403, headers
    for path in (
        "/replay/..%2f..%2f..%2fetc/passwd", "/replay/%2e%2e/class",
        "/replay/ann/..%2f..%2f..%2fscores", "/student/..%2fann/x", "/feedback/ann/index.html",
        "/store.sqlite",
    ):  # fmt: skip
        assert ada.ask("GET", path)[0] in (400, 404), path
    assert log_of(graded) == []
    headers = ada.ask("GET", f"/replay/ann/{SLUG}")[1]
    assert headers["Content-Security-Policy"].startswith("sandbox allow-scripts;")
    assert "Access-Control-Allow-Origin" not in headers


def test_what_is_held_is_assigned_and_accepted(
    grade_class: Any, handed_in: Path, tmp_path: Path
) -> None:
    (twins, roster), out = namesakes(handed_in), tmp_path / "out"
    mine = handed_in / moodles(twins[2], 0)
    (mine / FILE).rename(mine / "robot.py")
    (mine / "other.py").write_text("# 9\nprint('<script>')\n")
    grade_class(judge, roster=roster)
    with open_desk(out, "Ada") as addresses:
        ada = Visitor(addresses["Ada"])
        work = ada.page(f"/student/J%C3%B6rg%20M%C3%BCller/{SLUG}")
        assert "print(&#39;&lt;script&gt;&#39;)" in work
        for number in (0, 1):
            page = ada.page("/held")
            forms = [dict(each) for each in Forms(page).forms if ("kind", "assign") in each]
            wanted = {"kind": "assign", "line": forms[number]["line"]}
            key = folder_of(out, roster, number)
            said = ada.send(ada.send(page, wanted, person=key, why="asked"), {"sure": "1"})
            assert "The next course autograde" in said
        page = ada.page("/held")
        with reading(out) as class_:
            lines = [each.file for each in class_.options.account.lines]
        shown = ada.send(page, {"kind": "accept"}, line=str(lines.index("robot.py")), exercise=SLUG,
                         why="his")  # fmt: skip
        ada.send(shown, {"sure": "1"})
    grade_class(judge, roster=roster)
    keys = [folder_of(out, roster, number) for number in range(3)]
    assert [points(out)[key] for key in keys] == ["0", "1", "2"]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "no request"),
        ("Student: ann\nExercise: 1\nPlease look at:", "no request"),
        ("Student: nobody\nExercise: 1\nPlease look at: x", "expected one student"),
        ("Student: ann\nExercise: 7\nPlease look at: x", "unknown exercise of this class"),
        ("Student: ann\nExercise: 1\nCheck: x\nPlease look at: x", "unknown check"),
        ("Student: ann\nExercise: 1\nMoment: nan\nPlease look at: x", "expected a number"),
        ("Student: ann\nExercise: 1\nPlease look at: " + "x" * 2001, "at most 2000"),
    ],
)
def test_a_bad_request_says_what_is_wrong(graded: Path, text: str, why: str) -> None:
    with reading(graded) as class_, pytest.raises(InputError, match=why):
        asked.request(class_, text)


def test_a_bad_rubric_says_what_is_wrong(graded: Path) -> None:
    with reading(graded) as class_:
        with pytest.raises(InputError, match=r"expected a file rubric\.toml"):
            asked.style(class_, "ann", "1", {})
        (graded / asked.RUBRIC).write_text("[points]\nNames = 4\n")
        for given, why in (({}, "from 0 to 4"), ({"Names": 5}, "from 0 to 4"), ({"N": 1}, "Names")):
            with pytest.raises(InputError, match=why):
                asked.style(class_, "ann", "1", given)
        (graded / asked.RUBRIC).write_text("Names = 4\n")
        with pytest.raises(InputError, match=r"rubric\.toml: expected a table"):
            asked.style(class_, "ann", "1", {})
