"""Ask a model for everything that it could say: each answer is one that checks have to look at.

gains: nothing
score: 0
outcome: flooded
"""

from kit import drive

from grader.host.frames import MAX_ROWS, Question
from grader.host.supplied.kept import desk

ALL = Question(0, "predict", "model.pkl", 1, MAX_ROWS, bytes(40 * MAX_ROWS))


def ask(node, scan):
    for _ in range(60):
        desk.ask(ALL)


drive(ask)
