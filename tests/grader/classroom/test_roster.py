"""Rosters: sheets of the learning platforms and one's own, and who is meant by a download."""

from pathlib import Path

import pytest
from handing_in import matched

from grader.errors import InputError
from grader.lms.people import Match, Roster
from grader.lms.sheets import read_roster

CANVAS = (
    "Student,ID,SIS User ID,SIS Login ID,Section,Goal seeking (7),Current Score\n"
    ',,,,,Manual Posting,\n"    Points Possible",,,,,10,(read only)\n'
    '"Lee, Carla",12345,s1,clee,A,,\n"Müller, Zoë",333,s2,zoe@uni.edu,"A and B",7,\n'
    '"=""=1+1""",9,s3,=x,A,,\n'
)
MOODLE = (
    "First name,Last name,ID number,Email address,Last downloaded from this course\n"
    "Carla,Lee,4001,carla@uni.edu,1777900000\nZoë,Müller,4002,zoe@uni.edu,1777900000\n"
)
WORKSHEET = (
    "Identifier,Full name,Email address,Status,Grade,Maximum grade,Last modified (grade)\n"
    "Participant 4711,Carla Lee,carla@uni.edu,-,,50.00,-\n"
    "Participant 4712,Zoë Müller,zoe@uni.edu,-,,50.00,-\n"
)
GITHUB = '"identifier","github_username","github_id","name"\n"s1","Carla-L","1","Carla Lee"\n'
GRADESCOPE = "First Name,Last Name,SID,Email,Sections\nCarla,Lee,4001,carla@uni.edu,A\n"


def read(tmp_path: Path, *texts: str | bytes) -> Roster:
    files = []
    for number, text in enumerate(texts):
        files.append(tmp_path / f"{number}.csv")
        files[-1].write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_roster(files)


def name_of(roster: Roster, *asked: str) -> str:
    people = matched(roster, *asked).people
    return people[0].label if len(people) == 1 else ""


def test_canvas(tmp_path: Path) -> None:
    roster = read(tmp_path, CANVAS)
    assert [p.name for p in roster.people] == ["Lee, Carla", "Müller, Zoë", "=1+1"]
    assert [p.section for p in roster.people] == ["A", "A and B", "A"]
    assert roster.sheets[0].kind == "canvas"
    assert roster.sheets[0].points["Goal seeking (7)"] == "10"
    assert name_of(roster, "canvas", "whatever", "12345") == "Carla Lee"
    assert name_of(roster, "canvas", "leecarla", "999") == ""  # the id counts, not the name
    assert name_of(roster, "folder", "clee") == "Carla Lee"
    assert name_of(roster, "folder", "Zoë  müller") == "Zoë Müller"


def test_moodle_and_its_worksheets_are_one_roster(tmp_path: Path) -> None:
    second = WORKSHEET.replace("4711", "5822").replace("4712", "5823")
    roster = read(tmp_path, MOODLE, WORKSHEET, second)
    assert len(roster.people) == 2
    assert roster.people[0].participants == {"4711", "5822"}
    assert name_of(roster, "moodle", "Participant", "4712") == "Zoë Müller"
    assert name_of(roster, "moodle", "Carla Lee", "1") == "Carla Lee"
    # who renames herself like another after the worksheet was made is neither: a person decides
    assert name_of(roster, "moodle", "Zoë Müller", "4711") == ""
    assert name_of(roster, "moodle", "Zoë Müller", "9999") == "Zoë Müller"


def test_sheets_of_two_platforms(tmp_path: Path) -> None:
    roster = read(tmp_path, GRADESCOPE, GITHUB)
    (carla,) = roster.people
    assert carla.ids == {"sis": "4001", "email": "carla@uni.edu", "github": "Carla-L", "id": "s1"}
    assert name_of(roster, "github", "carla-l", "carla-l") == "Carla Lee"
    assert name_of(roster, "gradescope", "?", "4001") == "Carla Lee"
    assert name_of(roster, "gradescope", "?", "", "CARLA@uni.edu") == "Carla Lee"


@pytest.mark.parametrize(
    ("asked", "who"),
    [
        (("gradescope", "Eve", "4001", "eve@uni.edu"), "Eve Roe"),  # another's number, typed
        (("gradescope", "Carla Lee", "", "eve@home.org"), ""),
        (("gradescope", "4001", "", "eve@home.org"), ""),
        (("gradescope", "4001", ""), ""),
        (("github", "s1", "s1"), ""),  # a login like another's id
        (("github", "4001", "4001"), ""),
        (("github", "Carla Lee", "carla lee"), ""),
    ],
)
def test_nobody_takes_another_place(asked: tuple[str, ...], who: str, tmp_path: Path) -> None:
    eve = GRADESCOPE + "Eve,Roe,4002,eve@uni.edu,A\n"
    assert name_of(read(tmp_path, eve, GITHUB), *asked) == who


@pytest.mark.parametrize(
    "text",
    [
        "id;name;section\n1;Ann Lee;A\n2;Zoë;B\n".encode("cp1252"),
        "\ufeffid\tname\tsection\n1\tAnn Lee\tA\n2\tZoë\tB\n".encode(),
        "Name,ID,Group\r\n\r\nAnn Lee,1,A\r\nZoë,2,B\r\n".encode("utf-16"),
        b"name,id,section\nAnn Lee,1\nZo\xc3\xab,2,B,too many\n",
    ],
)
def test_a_csv_of_ones_own(tmp_path: Path, text: bytes) -> None:
    roster = read(tmp_path, text)
    assert [(p.name, p.ids["id"]) for p in roster.people] == [("Ann Lee", "1"), ("Zoë", "2")]
    assert roster.people[1].section == "B"


def test_ids_and_names_that_disagree_are_a_persons_to_decide(tmp_path: Path) -> None:
    names = "Name,SID,Email\nAnn Lee,12,ann@x\nBo Fox,0012,bo@x\n"
    groups = "name,canvas_user_id,group_name\nAnn Lee,1,Red Team\nBo Fox,2,Red Team\n"
    for text, asked in (
        (names, ("gradescope", "Ann Lee", "0012")),  # a number that a student typed
        (groups, ("canvas", "redteam", "3")),  # who handed in for the group is gone
        (groups, ("canvas", "redteam", "3", "")),
    ):
        match = matched(read(tmp_path, text), *asked)
        assert not match.people
        assert {person.name for person in match.may_be} == {"Ann Lee", "Bo Fox"}
    again = matched(read(tmp_path, GITHUB), "github", "Carla-L-1", "carla-l-1")
    assert [person.name for person in again.may_be] == ["Carla Lee"]  # a second repository


def test_a_number_typed_like_a_classmates_stops_nobody(tmp_path: Path) -> None:
    names = "Name,SID,Email\nAnn Lee,12,ann@x\nBo Fox,12,bo@x\nCy,13,cy@x\n"
    roster = read(tmp_path, names)
    assert [person.key for person in roster.people] == ["email:ann@x", "email:bo@x", "sis:13"]
    assert matched(roster, "gradescope", "Ann Lee", "12", "ann@x").people == roster.people[:1]


def test_canvas_with_first_and_last_names(tmp_path: Path) -> None:
    text = 'LastName,FirstName,ID,Section\nLee,Ann,1,A\n"=""=Cmd""",,2,A\n'
    assert [person.label for person in read(tmp_path, text).people] == ["Ann Lee", "=Cmd"]


def test_two_of_one_name_are_not_guessed(tmp_path: Path) -> None:
    roster = read(tmp_path, "id,name\n1,Ann Lee\n2,Ann Lee\n3,Bob\n")
    assert name_of(roster, "moodle", "Ann Lee", "71") == ""
    may_be = matched(roster, "moodle", "Ann Lee", "71").may_be
    assert [person.ids["id"] for person in may_be] == ["1", "2"]
    assert matched(roster, "moodle", "Eve", "71") == Match()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "expected a CSV with headings"),
        ("a,b\n1,2\n", "the headings are 'a, b'"),
        ("id,name\n1,Ann\n1,Bob\n", "two are 'Bob'"),
        ("id,name\nann,Ann\nAnn,Bob\n", "two are 'Bob'"),
        ("name\nAnn\nAnn\n", "add a column id"),
        ("\0\0\0", "expected a CSV"),
        ("name," + "x" * 200_000 + "\n" + "y" * 200_000, "a broken CSV"),
    ],
)
def test_what_is_no_roster(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read(tmp_path, text)
    with pytest.raises(InputError, match="cannot read the roster"):
        read_roster([tmp_path / "nowhere.csv"])


def test_canvas_and_gradescope_have_people_who_are_no_students(tmp_path: Path) -> None:
    canvas = CANVAS + f'"Estudiante, Prueba",99,,{"5d" * 20},A,,\n'
    roster = read(tmp_path, canvas, "Name,SID,Email,Role\nDi,s9,d@uni.edu,Instructor\n")
    assert len(roster.people) == 3


def test_two_id_numbers_for_one_person_are_refused(tmp_path: Path) -> None:
    other = "name,id number,email\nCarla Lee,4002,carla@uni.edu\n"
    with pytest.raises(InputError, match="one ID number per person, but 'Carla Lee' has '4002'"):
        read(tmp_path, MOODLE, other)
