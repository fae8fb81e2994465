"""GitHub Classroom's clones: `ASSIGNMENT-USER`, each a repository.

Source: github/gh-classroom, cmd/gh-classroom/clone/student-repos/student-repos.go: the clones lie
in `SLUG-submissions` and keep the repository's name, which GitHub Classroom makes of the
assignment's slug and the student's user name, with `-1` for who accepts the assignment twice
(github-education-resources/classroom, issue 1206). Git itself is never run in them.
"""

import os
from collections.abc import Sequence
from pathlib import Path

from grader.lms.names import numbered
from grader.lms.people import GITHUB, PARTICIPANT, Match, Person, Roster, squeezed
from grader.lms.platform import Entry, Platform, Read, Who, by_key, by_words

ENDING = "-submissions"


def read(folder: Path, paths: Sequence[Path]) -> Read:
    """Return the repositories if their names say which part is the student's."""
    clones = [path for path in paths if is_clone(path)]
    prefix = _prefix(folder, [path.name for path in clones])
    if not prefix:
        return Read(left=list(paths))
    there = [path for path in paths if path.is_dir() and not path.is_symlink()]  # or a copy
    theirs = [path for path in there if path.name.startswith(prefix) and path.name != prefix]
    return Read(
        [_entry(path, path.name.removeprefix(prefix)) for path in theirs],
        left=[path for path in paths if path not in set(theirs)],
    )


def _prefix(folder: Path, names: Sequence[str]) -> str:
    """Return what the names begin with: the folder's slug, or else what all have in common."""
    slug = folder.resolve().name
    if slug.endswith(ENDING):
        slug = slug.removesuffix(ENDING) + "-"
        if any(name.startswith(slug) for name in names):
            return slug
    common = os.path.commonprefix(names) if len(names) > 1 else ""  # noqa: RUF071 characters
    return common[: common.rfind("-") + 1]


def _entry(path: Path, user: str) -> Entry:
    return Entry(path, Who(user, PLATFORM, user.casefold()), version=numbered(user)[1])


def match(roster: Roster, who: Who, place: str) -> Match:
    """Return whom a repository or a login means; students choose their logins."""
    if team := roster.every(PARTICIPANT, place):
        return Match(team, sure=True)
    if not who.id or GITHUB not in roster.kinds:
        return by_words(roster, who, place)
    found, team = roster.one(GITHUB, who.id), roster.team(who.name, squeezed)
    if team and found is None:
        return Match(team, sure=True)
    return by_key(roster, who, found, team)


def times(roster: Roster, person: Person | None, entry: Entry) -> tuple[str, str]:
    """Return the time of a repository's submission, by GitHub Classroom's grades; no extension."""
    for sheet in roster.sheets:
        for row, place in zip(sheet.rows, sheet.people, strict=True):
            repository = sheet.cell(row, "student_repository_name").casefold()
            if roster.people[place] == person and repository == entry.path.name.casefold():
                return sheet.cell(row, "submission_timestamp"), ""
    return "", ""


def is_clone(path: Path) -> bool:
    """Return whether a folder is a repository, as far as it can be read."""
    return not path.is_symlink() and path.is_dir() and os.path.exists(path / ".git")  # noqa: PTH110


def sheet(header: Sequence[str]) -> str:
    """Return the kind of GitHub Classroom's `classroom_roster.csv`, or of an assignment's grades.

    The latter's columns are those of cmd/gh-classroom/assignment-grades.
    """
    of_one = {"github_username", "roster_identifier"} <= set(header)
    return "github" if of_one or {"github_username", "identifier"} <= set(header) else ""


PLATFORM = Platform(
    "GitHub Classroom", "github", read, sheet, id_kind=GITHUB, folds=True, match=match, times=times
)
