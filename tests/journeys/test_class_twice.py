"""A class, from Canvas's download to feedback and gradebook; and once more, with the late ones."""

import csv
import io
import zipfile
from collections.abc import Mapping

from person import ROOT, Person

FILE = "live_parameters_agent.py"
RIGHT = (ROOT / "solutions" / "live_parameters" / FILE).read_text("utf-8")
WRONG = "import rclpy.nod\n"
BO = "raybo_222_9002"
ROSTER = """
Student,ID,SIS User ID,SIS Login ID,Section,Live parameters (77),Current Score
    Points Possible,,,,,20,(read only)
"Lee, Carla",12345,s1,clee,A,,1.0
"Ray, Bo",222,s2,bray,B,,1.0
"Sum, Al",333,s3,asum,B,,1.0
"""
GRADE = "course autograde week.zip --roster gradebook.csv --out graded --trust"


def downloaded(person: Person, works: Mapping[str, str]) -> None:
    with zipfile.ZipFile(person.home / "week.zip", "w") as archive:
        for name, text in works.items():
            archive.writestr(name, text)


def points(person: Person) -> dict[str, str]:
    """Return what Canvas imports: who, points of 20."""
    text = (person.home / "graded" / "canvas" / "live_parameters.csv").read_text("utf-8-sig")
    return {
        row["Student"]: row["Live parameters (77)"] for row in csv.DictReader(io.StringIO(text))
    }


def feedback(person: Person) -> dict[str, str]:
    """Return the pages that go back to Canvas."""
    with zipfile.ZipFile(person.home / "graded" / "canvas" / "live_parameters-feedback.zip") as it:
        return {name: it.read(name).decode() for name in it.namelist()}


def test_from_a_download_to_feedback_and_gradebook_twice(person: Person) -> None:
    person.writes({"gradebook.csv": ROSTER})
    first = {f"leecarla_12345_9001_{FILE}": RIGHT, f"{BO}_{FILE}": WRONG}
    downloaded(person, first)
    listed = person.types("course autograde week.zip --roster gradebook.csv --list")
    assert "Al Sum (B): nothing handed in\nBo Ray (B): live_parameters" in listed
    assert "2 graded, 0 held for a person, 1 not handed in." in person.types(GRADE)
    assert points(person) == {"Lee, Carla": "20", "Ray, Bo": "0"}
    pages = feedback(person)
    assert set(pages) == {f"{mine}_live_parameters.html" for mine in ("leecarla_12345_9001", BO)}
    assert "No module named" in pages[f"{BO}_live_parameters.html"]
    person.types("course marks score graded 85 --exercise 10 --student clee --why 'by e-mail'")

    again = {f"raybo_222_9012_{FILE.replace('.py', '-1.py')}": RIGHT,
             f"sumal_LATE_333_9013_{FILE}": WRONG}  # fmt: skip
    downloaded(person, {f"leecarla_12345_9001_{FILE}": RIGHT, **again})
    person.writes({"gradebook.csv": ROSTER.replace("A,,1.0", "A,17,1.0")})
    assert "3 graded, 0 held for a person." in person.types(GRADE)
    assert points(person) == {"Lee, Carla": "17", "Ray, Bo": "20", "Sum, Al": "0"}
    pages = feedback(person)
    assert len(pages) == 3
    assert '"score":100,' in pages["raybo_222_9012_live_parameters.html"]
    assert "why: by e-mail" in person.types("course report graded")
