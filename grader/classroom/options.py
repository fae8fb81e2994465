"""How a class is graded: what `course autograde` is told."""

from dataclasses import dataclass

from grader.lms.people import NOBODY, Roster

CANARY_INTERVAL = 25  # units of an exercise between two rounds of canaries


@dataclass(frozen=True)
class Options:
    """The choices of the person who grades a class."""

    exercises: tuple[str, ...] = ()  # by name or number; (): every one that anybody handed in
    workers: int = 1
    dask: str = ""  # a scheduler's address or file, instead of local workers
    secret: bytes | None = None  # with it every student gets different worlds
    field: bool = False
    bags: bool = True
    trust: bool = False
    canaries: int = CANARY_INTERVAL  # 0: none
    hide: str = ""  # of what students see; "": nothing was said, so nothing is hidden
    retry_held: bool = False
    again: tuple[str, ...] = ()  # students whose nodes run once more
    only: tuple[str, ...] = ()  # students whose recordings are judged again; (): all
    roster: Roster = NOBODY  # with it everybody in it has a row
    add: bool = False  # to what is graded; who isn't in these downloads stays as they are
    drop: bool = False  # who isn't in them
    columns: tuple[str, ...] = ()  # "EXERCISE=TITLE": the gradebook's column of an exercise
