"""Ask for one huge object, as an accident would.

gains: nothing
score: 20
outcome: exception, completed
"""

from kit import attempt, drive, gained

with attempt():
    huge = bytes(5 * 1024**3)
    gained("has an object of 5 GiB")
drive()
