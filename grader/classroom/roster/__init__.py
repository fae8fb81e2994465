"""The roster: who is in the class, with the ids and sections of the learning platform."""

from grader.classroom.roster.people import NOBODY, Person, Roster, Sheet, folded
from grader.classroom.roster.sheets import read_roster

__all__ = ["NOBODY", "Person", "Roster", "Sheet", "folded", "read_roster"]
