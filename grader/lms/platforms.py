"""Learning platforms, one file each: what they hand over, and what they take back.

Nothing that is read here is trusted: an archive may be broken, locked, a bomb or a trap, a folder
may hold links to the instructor's files, and names are whatever students typed. A new platform is a
file with a `PLATFORM`, and a word in `PLATFORMS`.
"""

from grader.lms import canvas, folders, github, gradescope, moodle, nbgrader
from grader.lms.platform import Platform

# Each leaves what it does not know for the next; the last takes the rest.
PLATFORMS: tuple[Platform, ...] = (
    gradescope.PLATFORM, nbgrader.PLATFORM, moodle.PLATFORM, canvas.PLATFORM, github.PLATFORM,
    folders.PLATFORM,
)  # fmt: skip

_BY_WORD = {platform.word: platform for platform in PLATFORMS}


def platform_of(word: str) -> Platform:
    """Return the platform that the store calls so; plain folders for a word of no platform."""
    return _BY_WORD.get(word, folders.PLATFORM)
