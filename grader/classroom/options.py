"""How a class is graded: what `course autograde` is told."""

from __future__ import annotations

import hashlib
import hmac
import json
from dataclasses import dataclass

from grader.classroom.queue.store import Store
from grader.classroom.results.options import OPTIONS
from grader.errors import InputError
from grader.lms.people import NOBODY, Roster

CANARY_INTERVAL = 25  # units of an exercise between two rounds of canaries
SECRET = "secret"  # what the store calls the mark of the class's


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


def refuse_another(options: Options, store: Store) -> None:
    """Refuse what contradicts the last run into this folder.

    Raises InputError: the class has a secret, and this is none or another; or something was hidden
    from students, and nothing is said of that now.
    """
    secret, before = options.secret, store.kept(SECRET)
    # what tells one secret from another and nothing else of it
    mark = hmac.new(secret, b"this class", hashlib.sha256).hexdigest()[:16] if secret else ""
    if before not in ("", mark):
        raise InputError(
            "--secret: expected the file that this class was graded with, in whose worlds all its "
            f"results are, but there is {'another' if secret else 'none'}; for other worlds give "
            "another --out"
        )
    hidden = json.loads(store.kept(OPTIONS) or "{}").get("hide", "nothing")
    if not options.hide and hidden != "nothing":
        raise InputError(
            f"--hide: the last run hid {hidden} from students; give --hide {hidden} again, or "
            "--hide nothing"
        )
    store.keep(SECRET, mark)
