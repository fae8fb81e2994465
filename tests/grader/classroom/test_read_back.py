"""Whatever is stored can be read back: each field of each change, with the edges of its type.

The fields come from the structs, the commands and the desk's forms themselves, so that a new one is
tried, too. Where one is refused, an error of one line says so; nothing else may be raised.
"""

import contextlib
import math
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any, get_args, get_origin, get_type_hints

import click
import msgspec
import pytest
from desk_client import Forms
from fake_class import FILE, SLUG
from handing_in import put
from marked_class import ANN, judged, points

from grader.classroom.amendments import change as changes
from grader.classroom.amendments.change import Change, Unread, Whom
from grader.classroom.desk import pages
from grader.classroom.desk.asked import RUBRIC
from grader.classroom.desk.forms import Form
from grader.classroom.desk.marking import Marking, marking, reading
from grader.cli import marks, run
from grader.errors import GraderError, InputError
from grader.lms.sheets import read_roster
from grader.lms.told import moment, number, span, whole

MANY = "9" * 400
TEXTS = (
    "", "a\0b", "\udcff", "x" * 5000, "\u202ecba\u200f", "nan", "-0.0", "1e308", MANY, "1_0",
    "\u0665", f"{MANY}min", "9999-12-31T23:59:59-12:00", "0001-01-01T00:00+14:00",
)  # fmt: skip
FLOATS = (math.nan, math.inf, -math.inf, -0.0, 1e308, -1e308, 5e-324)
WHOLE = (0, -1, 2**63, 10**30, 10**400)
VALID = {
    "exercise": SLUG, "check": "slow_zone", "file": FILE, "zone": "UTC", "whom": ANN,
    "deadline": "2026-05-04T23:59+02:00", "times": {"ann": "2026-05-06T10:00+02:00"},
}  # fmt: skip
REQUEST = "Student: {}\nExercise: {}\nCheck: {}\nMoment: {}\nPlease look at: {}\n"
ASKED = ("ann", SLUG, "slow_zone", "2 s", "it is right")


def edges(of: Any) -> Iterator[Any]:
    """Yield the edges of a type, a valid value first."""
    parts = get_args(of)
    if of is float:
        yield from (1.0, *FLOATS)
    elif of is int:
        yield from (1, *WHOLE)
    elif of is bool:
        yield from (True, False)
    elif of is str:
        yield from ("x", *TEXTS)
    elif of is Whom:
        yield ANN
        for name, type_ in get_type_hints(Whom).items():
            yield from (Whom(**{name: each}) for each in edges(type_))
    elif get_origin(of) is dict:
        firsts = [next(edges(part)) for part in parts]
        yield from ({key: firsts[1]} for key in edges(parts[0]))
        yield from ({firsts[0]: value} for value in edges(parts[1]))
    elif get_origin(of) is tuple and parts[-1] is ...:
        yield from ((each,) for each in edges(parts[0]))
        yield ()
    elif get_origin(of) is tuple:
        firsts = [next(edges(part)) for part in parts]
        yield from ((*firsts[:at], each, *firsts[at + 1 :])
                    for at, part in enumerate(parts) for each in edges(part))  # fmt: skip
    else:  # X | None
        for part in parts:
            yield from edges(part) if part is not type(None) else (None,)


def every_change() -> Iterator[Change]:
    """Yield a change of each kind, and then with each field at each edge."""
    for kind in get_args(Change):
        types = get_type_hints(kind)
        base: dict[str, Any] = {
            name: VALID.get(name, next(edges(of))) for name, of in types.items()
        }
        for name, of in types.items():
            for each in edges(of):
                if kind is changes.Request and not getattr(each, "students", True):
                    continue  # nobody asks
                yield kind(**base | {name: each})


@pytest.fixture
def class_of(handed_in: Path, grade_class: Any, tmp_path: Path) -> Path:
    """Return the class: ann has asked something, dee is held, a file is nobody's."""
    put(handed_in, "dee/one.py", "dee/two.py", "stray.txt")
    grade_class(judged)
    (tmp_path / "out" / RUBRIC).write_text('[points]\n"Names" = 4\n"Parts & order" = 2\n')
    with marking(tmp_path / "out") as class_:
        class_.store.log(changes.Request(SLUG, "slow_zone", 2.0, "Why?", ANN), "ann", "sent")
    return tmp_path / "out"


@contextlib.contextmanager
def unwritten(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Write no results until the end: what is tried is what the log takes."""
    with monkeypatch.context() as patched:
        patched.setattr(Marking, "_written", lambda *_: ([], []))
        yield


@contextlib.contextmanager
def refused() -> Iterator[None]:
    """Let what is an error of one line, here and at the desk, pass; nothing else."""
    with contextlib.suppress(InputError, GraderError, OSError):
        yield


def look_everywhere(out: Path, grade_class: Any) -> None:
    """Run each command, and open each page of the desk."""
    ada: Any = SimpleNamespace(name="Ada", token="token")
    pages.class_page(out, ada, "", "")
    for page in (pages.marks_page, pages.held_page, pages.requests_page):
        page(out, ada)
    pages.student_page(out, ada, "ann", SLUG)
    for command in (("report",), ("report", "--student", "ann"), ("report", "--json", "-"),
                    ("marks", "undo", "1", "--why", "x"), ("marks", "write")):  # fmt: skip
        at = 2 if command[0] == "marks" else 1
        assert run([*command[:at], str(out), *command[at:]]) == 0, command
    grade_class(judged)
    assert points(out).keys() >= {"ann", "bob", "dee", "eve"}


# --- what a log may hold -------------------------------------------------------------------------


def test_each_field_of_each_change_is_refused_or_read_back(
    class_of: Path, grade_class: Any
) -> None:  # fmt: skip
    every, kept = list(every_change()), []
    with marking(class_of) as class_:
        for change in every:  # what is no error is as good as any
            with refused():
                class_.preview(change)
                kept.append(change)
        log = []
        for change in kept:
            if not isinstance(change, Unread | changes.Undo):
                with refused():
                    class_.store.log(change, "prof", "because")
                    log.append(change)
        assert [entry.change for entry in class_.entries][1:] == log
    assert len(every) > len(log) > 200
    look_everywhere(class_of, grade_class)


# --- what a person types -------------------------------------------------------------------------

TYPED: dict[str, list[str]] = {  # the arguments of each command
    "set": ["slow_zone", "5", "--student", "ann"], "waive": ["slow_zone", "--student", "ann"],
    "score": ["5", "--student", "ann"], "publish": ["--student", "ann"], "undo": ["2"],
    "late": ["--per-day", "10", "--deadline", "2026-05-04T23:59", "--student", "ann"],
    "assign": ["ann", "bob"], "accept": ["ann", FILE, "--exercise", "1"],
    "comment": ["ann", FILE, "1", "words"], "style": ["ann", "Names=1", "Parts & order=1"],
    "request": ["FILE"], "answer": ["1", "words"], "write": [],
}  # fmt: skip


def typed(files: Path) -> Iterator[list[str]]:
    """Yield the arguments of each command, with each of its parameters at each edge.

    An option that several commands have is the same one.
    """
    tried: set[object] = set()
    for name, command in marks.marks.commands.items():
        place = -2  # the folder is none of them
        for param in command.params:
            is_option, words = isinstance(param, click.Option), TYPED[name]
            place += not is_option
            if param.name == "folder" or param.name in tried or getattr(param, "is_flag", False):
                continue
            tried |= {param.name} if is_option else set()
            half = TEXTS[len(tried) % 2 :: 2]  # what a log may hold is tried above, with all
            texts = written(files, name) if isinstance(param.type, click.Path) else half
            for text in texts:
                if param.name == "section":
                    yield [name, *words[:-2], "--section", text]
                elif is_option:
                    yield [name, *words, param.opts[0], text]
                else:
                    said = f"Names={text}" if (name, param.name) == ("style", "points") else text
                    yield [name, *words[:place], said, *words[place + 1 :]]


def written(files: Path, which: str) -> Iterator[str]:
    """Yield files with an edge in the place of each thing that they say."""
    for n, text in enumerate(TEXTS):
        if which == "late":
            told = [f'id,time\nann,"{text}"\n', f'id,time\n"{text}",2026-05-04 10:00\n']
        else:
            at = n % len(ASKED)  # each takes a process
            told = [REQUEST.format(*ASKED[:at], text, *ASKED[at + 1 :])]
        for place, each in enumerate(told):
            file = files / f"{which}{n}.{place}"
            file.write_bytes(each.encode("utf-8", "surrogateescape"))
            yield str(file)


def test_each_argument_of_each_command(
    class_of: Path, tmp_path: Path, grade_class: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert TYPED.keys() == marks.marks.commands.keys()
    with unwritten(monkeypatch):
        for name, *words in typed(tmp_path):
            own = any(param.name == "why" for param in marks.marks.commands[name].params)
            why = ["--why", "x"] if own and "--why" not in words else []
            run(["marks", name, str(class_of), *words, *why])
            with reading(class_of) as class_:
                assert class_.entries, (name, words)
    look_everywhere(class_of, grade_class)


# --- what a person sends from the desk -----------------------------------------------------------


def test_each_field_of_each_form(
    class_of: Path, grade_class: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    ada: Any = SimpleNamespace(name="Ada", token="token")

    def forms() -> dict[str, dict[str, str]]:
        """Return for each kind of change the form with the most fields; somebody asks once more."""
        with marking(class_of) as class_:
            class_.store.log(changes.Request(SLUG, "", None, "And?", ANN), "ann", "sent")
        made = [pages.student_page(class_of, ada, "ann", SLUG)]
        made += [page(class_of, ada)
                 for page in (pages.marks_page, pages.held_page, pages.requests_page)]  # fmt: skip
        every = [form for page in made for form in Forms(page).every if "kind" in form]
        return {kind: {name: texts[0] for name, texts in form.items()} | {"kind": kind}
                for form in sorted(every, key=len) for kind in form["kind"]}  # fmt: skip

    usual = dict.fromkeys(("why", "words"), "x") | dict.fromkeys(("points", "line"), "1")
    usual |= {"check": "slow_zone", "per_day": "10", "student": "ann", "who": "students"}
    usual |= {"person": "bob", "text": REQUEST.format(*ASKED)}
    tried: set[str] = set()
    there = forms()
    assert there.keys() >= set(TYPED) - {"undo", "write"}
    with unwritten(monkeypatch):
        for kind in list(there):
            for name in sorted(there[kind].keys() - {"token", "back", *tried}):
                tried |= {name} - {"line", "points", "words"}  # others in other forms
                for text in TEXTS[len(tried) % 2 :: 2]:
                    sent = usual | {k: v for k, v in there[kind].items() if v} | {name: text}
                    coded = {k: [v.encode("utf-8", "replace")] for k, v in sent.items()}
                    try:
                        pages.changed(class_of, ada, Form.of(coded, {}))
                    except pages.Stale:
                        there = forms()
                    except (InputError, GraderError, OSError):
                        continue
    look_everywhere(class_of, grade_class)


# --- what is there already -----------------------------------------------------------------------


def test_an_entry_that_cannot_be_read_is_named_and_can_be_undone(
    graded: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Version 1.0.0 took a grace of 400 digits, and wrote null; without a deadline, any zone."""
    late = ("marks", "late", str(graded), "--all", "--per-day", "10", "--why", "x")
    assert run([*late, "--deadline", "2026-05-04T23:59", "--grace", f"{MANY}min"]) == 2
    assert "expected a time span such as 15min, 2h or 1d, at most 366d" in capsys.readouterr().err
    with marking(graded) as class_:
        class_.add(changes.Score(SLUG, 50, ANN), "prof", "x")
        class_.store.log(changes.Late(SLUG, 10, zone="Mars"), "prof", "x")
        text = msgspec.json.encode(changes.Late(SLUG, 10, grace=math.inf)).decode()
        class_.store._db.execute(
            "INSERT INTO amendments (at, who, what, why) VALUES ('', 'prof', ?, 'x')", (text,)
        )
    for command in ("report", "marks write", "marks undo"):
        at, entry = [*command.split(), str(graded)], ["1"] if command == "marks undo" else []
        assert run([*at, *entry, *(["--why", "x"] if entry else [])]) == 2
        said = capsys.readouterr().err
        assert "entry 3 of the log of marks can't be read" in said
        assert "`course marks undo FOLDER 3 --why" in said
    assert run(["marks", "undo", str(graded), "3", "--why", "can't be read"]) == 0
    assert run(["report", str(graded)]) == 0
    said = capsys.readouterr().out
    assert "[undone by 4]" in said
    assert "can't be read: Expected `float`, got `null` - at `$.grace`" in said
    assert points(graded)["ann"] == "50"


@pytest.mark.parametrize("system", ["nbgrader", "exchange", "gradescope", "moodle"])
def test_an_impossible_time_is_none_and_a_line_says_whose(
    system: str, handed_in: Path, grade_class: Any, tmp_path: Path, capsys: Any
) -> None:
    """Nobody's time stops the others; bob's, of a zone, is three days late in Berlin's."""
    late, mine = "2026-05-06 22:30:00", "9999-12-31T23:59:59-12:00"
    who, sheets = {"ann": mine, "bob": late, "eve": late}, []
    if system == "nbgrader":
        for name, time in who.items():
            put(handed_in / "submitted" / name / "one", **{"timestamp.txt": time, FILE: name})
            shutil.rmtree(handed_in / name)
    elif system == "exchange":
        mine = who["ann"] = "0001-01-01 00:00:00"
        for name, time in who.items():
            (handed_in / name).rename(handed_in / f"{name}+one+{time} UTC")
    elif system == "gradescope":
        told = ""
        for n, (name, time) in enumerate(who.items()):
            (handed_in / name).rename(handed_in / f"submission_{n}")
            told += f"submission_{n}:\n  :submitters:\n  - :name: {name}\n  :created_at: '{time}'\n"
        put(handed_in, **{"submission_metadata.yml": told})
    else:
        mine = "Friday, 31 December 9999, 11:59 PM"
        head = "Identifier,Full name,Grade,Maximum grade,Last modified (submission)\n"
        times = (mine, *["Thursday, 7 May 2026, 12:30 AM"] * 2)
        for n, (name, time) in enumerate(zip(who, times, strict=True)):
            (handed_in / name).rename(handed_in / f"{name}_{n}_assignsubmission_file")
            head += f'Participant {n},{name},,100,"{time}"\n'
        sheets = [put(tmp_path, **{"sheet.csv": head}) / "sheet.csv"]
    grade_class(judged, roster=read_roster(sheets))
    out = tmp_path / "out"
    found = [
        line
        for line in (out / "intake.csv").read_text("utf-8").splitlines()
        if "is no time" in line
    ]
    assert len(found) == 1
    assert "ann,obstacle_avoidance,not understood" in found[0] and mine in found[0]
    assert "is no time, and counts as none; expected a time of the years 1970 to 2199" in found[0]
    rule = ("--per-day", "10", "--deadline", "2026-05-04T23:59", "--zone", "Europe/Berlin")
    assert run(["marks", "late", str(out), "--all", *rule, "--why", "x"]) == 0
    assert "not counted as late: ann" in capsys.readouterr().out
    assert points(out) == {"ann": "70", "bob": "40", "eve": ""}
    grade_class(judged, roster=read_roster(sheets))
    assert run(["marks", "undo", str(out), "1", "--why", "x"]) == 0


@pytest.mark.parametrize(
    ("read", "right", "wrong"),
    [
        (number, ("0", "8.5", " 100 ", "1e2", "1000000"), ("1_0", "\u0665", "-0", "1e7", "0x1")),
        (whole, ("1", "007"), ("1_0", "\u0665", "0", "1.9", "1" * 10)),
        (span, ("15min", "2 h", "366d", "5"), ("\u0665min", f"{MANY}min", "367d", "-1", "")),
        (lambda text: moment(text) or span(""),
         ("2199-12-31T23:59", "1970-01-01 00:00", "4 May 2026, 9:12 AM", "04/05/2026 10:00"),
         ("2200-01-01", "1969-12-31", "\u0662026-05-04", "9999-12-31T23:59:59-12:00", "")),
    ],
)  # fmt: skip
def test_one_reader_for_each(read: Any, right: Sequence[str], wrong: Sequence[str]) -> None:
    for text in right:
        assert read(text) is not None
    for text in wrong:
        with pytest.raises(InputError):
            read(text)
