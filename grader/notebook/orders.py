"""The messages between the kernel and its judge: one JSON object a line."""

import msgspec


class Warm(msgspec.Struct, frozen=True, tag="warm"):
    """Get ready for nodes that import these modules. Has no answer."""

    libraries: tuple[str, ...] = ()


class Drive(msgspec.Struct, frozen=True, tag="drive"):
    """Run a node in a scenario."""

    file: str  # absolute path
    shown: str  # its name in messages
    scenario: str
    lidar: str | None = None
    goals: tuple[tuple[float, float], ...] = ()
    params: tuple[str, ...] = ()  # NAME:=VALUE
    duration: float | None = None  # [s]
    seed: int | None = None
    libraries: tuple[str, ...] = ()
    at: tuple[float, ...] = ()  # moments to look into [s]
    callback: str = ""  # the function to show there


class Grade(msgspec.Struct, frozen=True, tag="grade"):
    """Judge an exercise."""

    exercise: str
    file: str  # absolute path
    shown: str
    only: tuple[str, ...] = ()
    field: bool = False


class Look(msgspec.Struct, frozen=True, tag="look"):
    """Look for the smallest world in which a node fails."""

    exercise: str
    file: str  # absolute path
    shown: str
    minutes: float | None = None
    tries: int | None = None
    seed: int = 0
    field: bool = False


Order = Warm | Drive | Grade | Look


class Progressed(msgspec.Struct, frozen=True, tag="progress"):
    """How far a grading is."""

    what: str  # "trial", "check" or "world"
    done: int
    of: int
    name: str = ""  # of the scenario or the check; how far a search is
    outcome: str = ""  # of a check; how a trial ended; "": it begins


class Driven(msgspec.Struct, frozen=True, tag="driven"):
    """The result of a drive, or of a search."""

    text: str  # the summary
    page: str  # HTML, the replay; "" if a search found nothing


class Graded(msgspec.Struct, frozen=True, tag="graded"):
    """The result of a grading."""

    grading: str  # the JSON object of `course grade --json`
    text: str  # the terminal's table
    page: str  # HTML, replays; "" if there are none
    first: str = ""  # title of the first replay
    changed: str = ""  # since the last attempt


class Problem(msgspec.Struct, frozen=True, tag="problem"):
    """An order could not be carried out."""

    text: str  # a sentence
    fault: bool = False  # of the grader or the machine, not of the student


Answer = Progressed | Driven | Graded | Problem
