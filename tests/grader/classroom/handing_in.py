"""Files as a class hands them in, and what is made of them."""

import io
import tarfile
import zipfile
from pathlib import Path

from grader.classroom.intake.exercise_files import find_files
from grader.classroom.intake.students import Intake, take_in
from grader.lms.people import Match, Roster
from grader.lms.platform import Who
from grader.lms.platforms import platform_of
from grader.lms.sheets import read_roster

AGENT = "obstacle_avoidance_agent.py"


def put(place: Path, *names: str, **files: str | bytes) -> Path:
    """Lay files into a folder, or pack them if it is called so; those of `names` hold these."""
    every = {name: f"# {name}\n" for name in names} | files
    data = {
        name: each if isinstance(each, bytes) else each.encode() for name, each in every.items()
    }
    place.parent.mkdir(parents=True, exist_ok=True)
    if place.suffix == ".zip":
        with zipfile.ZipFile(place, "w", zipfile.ZIP_DEFLATED) as packed:
            for name, each in data.items():
                packed.writestr(name, each)
    elif place.suffix in (".tar", ".gz", ".tgz"):
        tarred(place, *((tarfile.TarInfo(name), each) for name, each in data.items()))
    else:
        for name, each in data.items():
            (place / name).parent.mkdir(parents=True, exist_ok=True)
            (place / name).write_bytes(each)
    return place


def tarred(path: Path, *members: tuple[tarfile.TarInfo, bytes]) -> None:
    with tarfile.open(path, "w" if path.suffix == ".tar" else "w:gz") as archive:
        for info, data in members:
            info.size = len(data)
            archive.addfile(info, io.BytesIO(data))


def taken(*sources: Path, roster: Path | None = None) -> Intake:
    people = read_roster([roster] if roster else [])
    return take_in(list(sources), sources[0].parent / "scratch", people)


def roster_of(folder: Path, text: str) -> Roster:
    """Return the people of a sheet of this text."""
    return read_roster([put(folder, **{"roster.csv": text}) / "roster.csv"])


def matched(roster: Roster, system: str, name: str, id_: str = "", *email: str) -> Match:
    """Return whom a platform's download means by a name, an id and an address."""
    platform = platform_of(system)
    return platform.match(roster, Who(name, platform, id_, *email), "")


def graded(intake: Intake) -> dict[str, str]:
    """Return what each student's graded file holds."""
    found = {student.id: find_files(student, [AGENT]) for student in intake.students}
    return {
        id_: each.files[AGENT].read_text()[2:-1] if each.files else each.problem
        for id_, each in found.items()
    }


def faults(intake: Intake) -> dict[str, str]:
    return {each.name: each.reason for each in intake.set_aside if each.fault}
