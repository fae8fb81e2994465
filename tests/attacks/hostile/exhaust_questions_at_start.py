"""Ask the judge's models again and again in the start-up, and take one's time for each question.

gains: nothing
score: 0
outcome: hung
"""

from kit import attempt, drive, libc

from grader.host.frames import Question
from grader.host.supplied.kept import desk

for _ in range(1_000):
    with attempt():
        desk.ask(Question(0, "load", "model.pkl"))
    libc.usleep(900_000)

drive()
