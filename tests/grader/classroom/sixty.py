"""A class of 60 as each platform hands it over, made of the course's variants and mutants.

`python tests/grader/classroom/test_sixty.py` prints the table of what became of every file.
"""

from __future__ import annotations

import csv
import io
import random
import tarfile
import zipfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

from grader.authoring.mutants import mutants, submission_of
from grader.course.exercises import find_exercise

AGENTS = {
    "obstacle_avoidance": "obstacle_avoidance_agent.py",
    "goal_seeking": "goal_seeking_agent.py",
}
ONE, THREE = AGENTS.values()
FIRST = (
    "Ann", "Bob", "Zoë", "Кира", "李", "O'Neil", "Jean-Luc", "María José", "Søren", "Nguyễn", "Al",
    "Ida",
)  # fmt: skip
LAST = ("Lee", "Ünal", "van der Berg", "Ray", "Ø", "Müller", "de la Cruz", "Smith-Jones")
ODD = ("=1+1 Formula", "@Sum Total", "\u202eevil Name", "Con Nul", "A" * 60 + " Long", "Ann LEE")


@dataclass(frozen=True)
class Someone:
    """One of the class, and what they hand in."""

    number: int
    first: str
    last: str
    files: dict[str, bytes]  # by the exercise's file
    older: bool = False  # handed in an earlier version of the first file, too
    packed: bool = False
    strange: str = ""  # hands in only a file of this name

    @property
    def name(self) -> str:
        return f"{self.first} {self.last}"

    @property
    def login(self) -> str:
        return f"u{self.number:03}"


@dataclass
class Download:
    """A class as one platform hands it over."""

    sources: list[Path]
    rosters: list[Path] = field(default_factory=list)
    entries: int = 0  # files that students uploaded
    junk: int = 0  # entries that are nobody's
    participants: dict[tuple[str, str], str] = field(default_factory=dict)  # exercise, login


def everybody() -> list[Someone]:
    """60 people: two of one name, six who hand in nothing, odd names, odd files."""
    chance = random.Random(60)
    texts = {slug: list(_texts(slug)) for slug in AGENTS}
    people = []
    for number in range(60):
        first, last = FIRST[number % len(FIRST)], LAST[number // len(FIRST) % len(LAST)]
        if number < 2:
            first, last = "Ann", "Lee"
        elif number >= 54:
            first, _, last = ODD[number - 54].rpartition(" ")
        files = {}
        for slug, share in (("obstacle_avoidance", 0.9), ("goal_seeking", 0.6)):
            if chance.random() < share:
                text = texts[slug][number % len(texts[slug])]
                files[AGENTS[slug]] = f"# {number} {slug}\n{text}".encode()
        if 20 <= number < 26:
            files = {}
        strange = {30: "robot.py", 31: "homework.rar"}.get(number, "")
        people.append(
            Someone(
                number, first, last, {} if strange else files or _for_sure(number, texts),
                older=number % 7 == 3, packed=number % 9 == 4, strange=strange,
            )
        )  # fmt: skip
    return people


def _for_sure(number: int, texts: dict[str, list[str]]) -> dict[str, bytes]:
    if 20 <= number < 26:
        return {}
    return {ONE: f"# {number} obstacle_avoidance\n{texts['obstacle_avoidance'][0]}".encode()}


def _texts(slug: str) -> Iterable[str]:
    exercise = find_exercise(slug)
    first = exercise.files[0]
    yield (exercise.solutions / first).read_text("utf-8")
    for variant in sorted((exercise.solutions / "variants").glob("*.py")):
        yield variant.read_text("utf-8")
    for mutant in mutants(exercise):
        yield submission_of(exercise, mutant)[first]


def uploads(person: Someone, file: str) -> list[tuple[str, bytes]]:
    """Return what a person uploads to the assignment of one file, in order of time."""
    if person.strange:
        return [(person.strange, b"print('hello')\n")] if file == ONE else []
    text = person.files.get(file)
    if text is None:
        return []
    if person.packed:
        target = io.BytesIO()
        with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr(f"work/{file}", text)
        return [("homework.zip", target.getvalue())]
    if person.older and file == next(iter(person.files)):
        return [(file, b"# an early version\n"), (file.replace(".py", "-1.py"), text)]
    return [(file, text)]


def write(path: Path, data: bytes | str = b"") -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data.encode() if isinstance(data, str) else data)


def own_roster(people: list[Someone], file: Path) -> Path:
    target = io.StringIO()
    writer = csv.writer(target)
    writer.writerow(["id", "name", "section", "login", "email", "github_user"])
    for p in people:
        writer.writerow([f"{4000 + p.number}", p.name, "AB"[p.number % 2], p.login,
                         f"{p.login}@uni.edu", f"gh-{p.login}"])  # fmt: skip
    write(file, target.getvalue().replace("github_user", "github"))
    return file


# --- the platforms -------------------------------------------------------------------------------


def canvas(people: list[Someone], place: Path) -> Download:
    """Make a zip of flat files per assignment, and the gradebook's export."""
    from importers import Canvas  # noqa: PLC0415

    book = Canvas(
        {100 + p.number: (f"{p.last}, {p.first}", p.login) for p in people},
        {71: ("Obstacle avoidance", "100"), 73: ("Week 3: Goal seeking", "50")},
    )
    write(place / "gradebook.csv", book.export())
    made = Download([], [place / "gradebook.csv"])
    attachment = 9000
    for file in AGENTS.values():
        source = place / f"{file[:-3]} submissions.zip"
        with zipfile.ZipFile(source, "w", zipfile.ZIP_DEFLATED) as archive:
            for p in people:
                prefix = "".join(c for c in f"{p.last}{p.first}" if c.isalnum()).lower()
                late = "LATE_" if p.number % 10 == 5 else ""
                for name, data in uploads(p, file):
                    attachment += 1
                    member = f"{prefix}_{late}{100 + p.number}_{attachment}_{name}"
                    archive.writestr(member, data)
                    made.entries += 1
            archive.writestr("index.html", "<p>nobody's</p>")
            made.junk += 1
        made.sources.append(source)
    return made


def _moodle(people: list[Someone], place: Path, folders: bool) -> Download:
    made = Download([])
    for number, (slug, file) in enumerate(AGENTS.items()):
        folder = place / slug
        folder.mkdir()
        target = io.StringIO()
        writer = csv.writer(target)
        headings = "Identifier,Full name,Email address,Status,Grade,Maximum grade"
        writer.writerow([*headings.split(","), "Last modified (grade)", "Feedback comments"])
        for p in people:
            id_ = str(7000 + 100 * number + p.number)
            made.participants[slug, p.login] = id_
            writer.writerow([f"Participant {id_}", p.name, f"{p.login}@uni.edu", "Submitted", "",
                             "100.00", "-", ""])  # fmt: skip
            prefix = f"{p.name.replace('_', ' ')}_{id_}_assignsubmission_file"
            for name, data in uploads(p, file):
                write(folder / (f"{prefix}/{name}" if folders else f"{prefix}_{name}"), data)
                made.entries += 1
        write(place / f"Grades-{slug}.csv", target.getvalue())
        write(folder / "notes.txt", "nobody's")
        made.junk += 1
        made.sources.append(folder)
        made.rosters.append(place / f"Grades-{slug}.csv")
    return made


def moodle_folders(people: list[Someone], place: Path) -> Download:
    """Make a folder per student and assignment, and the grading worksheets."""
    return _moodle(people, place, folders=True)


def moodle_flat(people: list[Someone], place: Path) -> Download:
    """Make flat files, and the grading worksheets."""
    return _moodle(people, place, folders=False)


def nbgrader(people: list[Someone], place: Path) -> Download:
    """Make an exchange's inbound folder; earlier attempts stay in it."""
    made = Download([place / "course"], [own_roster(people, place / "class.csv")])
    for week, file in enumerate(AGENTS.values()):
        for p in people:
            for nth, (name, data) in enumerate(uploads(p, file)):
                time = f"2026-05-{4 + 7 * week:02} 1{nth}:00:00.000000 UTC"
                attempt = f"{p.login}+week{week}+{time}+r{nth}_x"
                name = file if name.endswith("-1.py") else name  # noqa: PLW2901
                write(place / "course/inbound" / attempt / name, data)
                made.entries += 1
    write(place / "course/inbound/README", "nobody's")
    write(place / "course/outbound/week0/01_loop.ipynb", "{}")
    return made


def github(people: list[Someone], place: Path) -> Download:
    """Make clones; git keeps one version, the last."""
    made = Download([], [own_roster(people, place / "class.csv")])
    for slug, file in AGENTS.items():
        folder = place / f"{slug.replace('_', '-')}-submissions"
        for p in people:
            repository = folder / f"{slug.replace('_', '-')}-gh-{p.login}"
            there = uploads(p, file)[-1:]
            if there:
                write(repository / ".git/HEAD", "ref: refs/heads/main\n")
            for name, data in there:
                write(repository / (file if name.endswith("-1.py") else name), data)
                made.entries += 1
        write(folder / "notes.txt", "nobody's")
        made.junk += 1
        made.sources.append(folder)
    return made


def gradescope(people: list[Someone], place: Path) -> Download:
    """Make an export per assignment with its metadata; only last submissions are in it."""
    made = Download([], [own_roster(people, place / "class.csv")])
    for number, file in enumerate(AGENTS.values()):
        folder = place / f"assignment_{number}_export"
        metadata = []
        for p in people:
            for name, data in uploads(p, file)[-1:]:
                submission = f"submission_{5000 + 100 * number + p.number}"
                write(folder / submission / (file if name.endswith("-1.py") else name), data)
                made.entries += 1
                quoted = p.name.replace("'", "''").replace("\u202e", "")
                metadata += [f"{submission}:", "  :submitters:", f"  - :name: '{quoted}'",
                             f"    :sid: '{4000 + p.number}'", f"    :email: {p.login}@uni.edu",
                             "  :created_at: 2026-05-04 10:11:12.000000000 -07:00"]  # fmt: skip
        write(folder / "submission_metadata.yml", "\n".join(metadata) + "\n")
        write(folder / f"submission_1/{file}", "nobody's")
        made.junk += 1
        made.sources.append(folder)
    return made


def by_hand(people: list[Someone], place: Path) -> Download:
    """Make a folder, a zip or a tar.gz per student, called by their login."""
    made = Download([place / "handed_in"], [own_roster(people, place / "class.csv")])
    for p in people:
        files = [each for file in AGENTS.values() for each in uploads(p, file)]
        loose = [(name, data) for name, data in files if not name.endswith(".zip")]
        made.entries += len(files)
        for name, data in files:
            if name.endswith(".zip"):  # one archive per student: its members lie in the folder
                with zipfile.ZipFile(io.BytesIO(data)) as archive:
                    loose += [(m, archive.read(m)) for m in archive.namelist()]
        if not files:
            continue
        if p.number % 3 == 0:
            for name, data in loose:
                write(place / "handed_in" / p.login / name, data)
        elif p.number % 3 == 1:
            (place / "handed_in").mkdir(exist_ok=True)
            with zipfile.ZipFile(place / "handed_in" / f"{p.login}.zip", "w") as archive:
                for name, data in loose:
                    archive.writestr(name, data)
        else:
            (place / "handed_in").mkdir(exist_ok=True)
            with tarfile.open(place / "handed_in" / f"{p.login}.tar.gz", "w:gz") as packed:
                for name, data in loose:
                    info = tarfile.TarInfo(name)
                    info.size = len(data)
                    packed.addfile(info, io.BytesIO(data))
    write(place / "handed_in/notes.txt", "nobody's")
    made.junk += 1
    return made


FORMATS: dict[str, Callable[[list[Someone], Path], Download]] = {
    "Canvas": canvas, "Moodle, folders": moodle_folders, "Moodle, flat": moodle_flat,
    "nbgrader exchange": nbgrader, "GitHub Classroom": github, "Gradescope": gradescope,
    "folders and archives": by_hand,
}  # fmt: skip
