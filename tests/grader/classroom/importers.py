"""Reads gradebook files by the rules of the platforms that import them, in Python.

Each class says which source its rules are from; they were read, not copied.
"""

import csv
import io
import re
import zipfile
from dataclasses import dataclass, field
from typing import Any


def to_i(text: str) -> int:
    """Ruby's `String#to_i`."""
    match = re.match(r"\s*[-+]?\d+", text)
    return int(match[0]) if match else 0


@dataclass
class Canvas:
    """A course of Canvas's. Source: instructure/canvas-lms, lib/gradebook_importer.rb."""

    users: dict[int, tuple[str, str]]  # id: sortable name, login
    assignments: dict[int, tuple[str, str]]  # id: title, points possible
    scores: dict[tuple[int, int], str] = field(default_factory=dict)
    unassigned: set[tuple[int, int]] = field(default_factory=set)
    changes: dict[tuple[int, int], str] = field(default_factory=dict)
    new_users: list[str] = field(default_factory=list)
    new_assignments: list[str] = field(default_factory=list)
    new_points: dict[int, str] = field(default_factory=dict)

    def export(self) -> str:
        """What "Gradebook > Export" writes (lib/gradebook_exporter.rb), names quoted as there."""
        target = io.StringIO()
        writer = csv.writer(target)
        titles = [f"{title} ({id_})" for id_, (title, _) in self.assignments.items()]
        total = ["Current Score", "Final Score"]
        info = ["Student", "ID", "SIS User ID", "SIS Login ID", "Section"]
        writer.writerow([*info, *titles, *total])
        writer.writerow([*[""] * 5, *["Manual Posting" for _ in titles], "", ""])
        possible = [points for _, points in self.assignments.values()]
        only = ["(read only)"] * 2
        writer.writerow(["    Points Possible", "", "", "", "", *possible, *only])
        for id_, (name, login) in self.users.items():
            shown = f'="{name}"' if re.match(r"\s*=", name) else name
            scores = [
                "N/A" if (id_, a) in self.unassigned else self.scores.get((id_, a), "")
                for a in self.assignments
            ]
            writer.writerow([shown, id_, f"sis{id_}", login, "Section A", *scores, "1.0", "1.0"])
        return target.getvalue()

    def load(self, text: str) -> None:
        """Take a file in, and note what would change."""
        lines = [line for line in csv.reader(io.StringIO(text, newline="")) if any(line)]
        header = lines[0]
        assert len(header) > 3
        assert "Student" in header[0]
        assert "ID" in header[1]
        columns, login, sis = 3, None, None
        if re.search(r"SIS\s+Login\s+ID", header[2]):
            columns, login = 4, 2
        elif re.search(r"SIS\s+User\s+ID", header[2]) and re.search("SIS\\s+Login", header[3]):
            columns, sis, login = 5, 2, 3
        assert "Section" in header[columns - 1], "invalid header row"
        found = {place: self._assignment(header[place]) for place in range(columns, len(header))}
        for row in lines[1:]:
            if "Points Possible" in row[0]:
                for place, assignment in found.items():
                    if row[place] and row[place] != self.assignments.get(assignment, ("", ""))[1]:
                        self.new_points[assignment] = row[place]
                continue
            user = self._user(row, login, sis)
            for place, assignment in found.items():
                self._score(user, assignment, row[place].strip())

    def _assignment(self, heading: str) -> int:
        match = re.fullmatch(r"(.*)\s\((\d+)\)", heading)
        if match and int(match[2]) in self.assignments:
            return int(match[2])
        same = [id_ for id_, (title, _) in self.assignments.items() if title == heading]
        if same:
            return same[0]
        self.new_assignments.append(heading)
        return -len(self.new_assignments)

    def _user(self, row: list[str], login: int | None, sis: int | None) -> int:
        if row[1] and to_i(row[1]) in self.users:
            return to_i(row[1])
        if sis is not None and row[sis].startswith("sis") and to_i(row[sis][3:]) in self.users:
            return to_i(row[sis][3:])
        logins = {known[1]: id_ for id_, known in self.users.items()}
        if login is not None and row[login] in logins:
            return logins[row[login]]
        names = {known[0]: id_ for id_, known in self.users.items()}
        if row[0] in names:
            return names[row[0]]
        self.new_users.append(row[0])
        return -len(self.new_users)

    def _score(self, user: int, assignment: int, new: str) -> None:
        if (user, assignment) in self.unassigned:
            new = ""
        old = self.scores.get((user, assignment), "")
        if new == old or (old in ("", "-") and new in ("", "-")):
            return
        if old and new and "EX" not in (old.upper(), new.upper()) and float(old) == float(new):
            return
        self.changes[user, assignment] = new


# The words of the language packs: lang/*/assign.php, grades.php and moodle.php
MOODLE = {
    "en": (
        "Participant ", "Identifier", "Full name", "Email address", "Status", "Grade",
        "Maximum grade", "Grade can be changed", "Last modified (submission)",
        "Last modified (grade)", "Feedback comments", "Yes", "No", "Monday, 4 May 2026, 9:12 AM",
    ),
    "de": (
        "Teilnehmer/in", "ID", "Vollständiger Name", "E-Mail-Adresse", "Status", "Bewertung",
        "Beste Bewertung", "Bewertung kann geändert werden", "Zuletzt geändert (Abgabe)",
        "Zuletzt geändert (Bewertung)", "Feedback als Kommentar", "Ja", "Nein",
        "Montag, 4. Mai 2026, 09:12",
    ),
    "fr": (
        "Participant", "Identifiant", "Nom complet", "Adresse de courriel", "Statut", "Note",
        "Note maximale", "La note peut être modifiée", "Dernière modification (travail remis)",
        "Dernière modification (note)", "Feedback par commentaires", "Oui", "Non",
        "lundi 4 mai 2026, 09:12",
    ),
    "es": (
        "Participante", "Identificador", "Nombre completo", "Dirección de correo", "Estado",
        "Calificación", "Calificación máxima", "La calificación puede ser cambiada",
        "Última modificación (entrega)", "Última modificación (calificación)",
        "Comentarios de retroalimentación", "Sí", "No", "lunes, 4 de mayo de 2026, 09:12",
    ),
}  # fmt: skip


@dataclass
class MoodleAssignment:
    """One assignment. Sources: mod/assign/feedback/offline and mod/assign/feedback/file."""

    participants: dict[str, str]  # unique id: user
    maximum: float
    grades: dict[str, tuple[float, int]] = field(default_factory=dict)  # grade, when
    files: dict[str, dict[str, bytes]] = field(default_factory=dict)
    skipped: list[str] = field(default_factory=list)
    language: str = "en"

    @property
    def words(self) -> tuple[str, ...]:
        """What `get_string` says."""
        return MOODLE[self.language]

    def worksheet(self, names: dict[str, str], locked: tuple[str, ...] = ()) -> str:
        """What "Download grading worksheet" writes."""
        target = io.StringIO()
        writer = csv.writer(target)
        hidden, *headings, yes, no, at = self.words
        writer.writerow(headings)
        for id_, user in self.participants.items():
            grade, when = self.grades.get(user, ("", 0))
            writer.writerow(
                [f"{hidden}{id_}", names[id_], f"{user}@uni.edu", "Submitted", grade,
                 f"{self.maximum:.2f}", no if user in locked else yes,
                 at, f"{at} {when}" if when else "-",
                 "<p>well done</p>"]
            )  # fmt: skip
        return target.getvalue()

    def load(self, text: str) -> None:
        """Upload a worksheet; grades that Moodle skips are noted."""
        header, *rows = csv.reader(io.StringIO(text, newline=""))
        hidden, identifier, *_, changed, feedback, _, _, _ = self.words
        id_, grade = header.index(identifier), header.index(self.words[5])
        modified = header.index(changed)
        assert feedback not in header, "feedback would be replaced"
        for row in rows:
            user = self.participants.get(row[id_][len(hidden) :])
            if user is None:
                self.skipped.append(row[id_])
                continue
            old, when = self.grades.get(user, (None, 0))
            told = re.search(r"(\d+)$", row[modified])
            stale = when > (int(told[1]) if told else 0) + 60
            value = row[grade]
            new = float(value) if value else -1.0
            if old == new:
                continue
            if not 0 <= new <= self.maximum or (old is not None and stale):
                self.skipped.append(row[id_])
                continue
            self.grades[user] = (new, when + 1)

    def load_feedback(self, data: Any) -> None:
        """Upload feedback files in a zip."""
        with zipfile.ZipFile(data) as archive:
            for name in archive.namelist():
                parts = ["", "import", *name.split("/")]
                while parts:
                    info = parts.pop(0).split("_", 4)
                    if len(info) < 4 or not info[1].isdecimal() or info[1] not in self.participants:
                        continue
                    assert (info[2], info[3]) == ("assignfeedback", "file")
                    user = self.participants[info[1]]
                    file = "/".join(filter(None, [*info[4:], *parts]))
                    self.files.setdefault(user, {})[file] = archive.read(name)
                    break
                else:
                    self.skipped.append(name)
