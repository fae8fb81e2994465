"""A class to grade: hostile submissions, and honest ones of every kind and several exercises."""

import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

from arena import HERE, Trick

from grader.authoring.claims import claims
from grader.course.exercises import find_exercise

COURSE = [sys.executable, "-m", "grader.cli", "autograde"]
# exercise: right and wrong solutions, by the names of their claims
HONEST = {
    "obstacle_avoidance": (
        "obstacle_avoidance_agent", "compact", "numpy_vectorised", "worker_thread_queue",
        "brakes_too_late", "dies_of_an_empty_scan", "dies_in_the_constructor",
    ),
    "goal_seeking": (
        "goal_seeking_agent", "compact", "state_machine", "checks_only_x", "deaf_after_arrival",
    ),
    "trend_memory": ("trend_agent", "running_sums", "afraid_of_leaving", "big_squares"),
    "slow_model": ("decoupled_controller", "dies_without_a_model"),
    "safety_supervisor": ("safety_supervisor", "all_errors"),
}  # fmt: skip


def honest() -> dict[str, dict[str, str]]:
    """Return the honest submissions: the files' texts, by student."""
    found = {}
    for slug, names in HONEST.items():
        known = {c.stem: c for c in claims(find_exercise(slug)) if c.kind != "skeleton"}
        for name in names:
            found[f"{slug}-{name}"] = dict(known[name].files)
    return found


def kit() -> str:
    """Return what puts the hostile files' kit in front of them: here each is one file."""
    texts = {name: (HERE / f"{name}.py").read_text("utf-8") for name in ("kit", "seeing")}
    return (
        "import sys as _s, types as _t\n"
        f"for _n, _x in {texts!r}.items():\n"
        "    _m = _s.modules[_n] = _t.ModuleType(_n)\n"
        "    _m.__file__ = __file__\n"
        "    exec(_x, _m.__dict__)\n"
    )


def hand_in(folder: Path, student: str, files: Mapping[str, str | bytes]) -> None:
    """Put a student's files where a class hands in."""
    (folder / student).mkdir(parents=True)
    for name, content in files.items():
        data = content.encode() if isinstance(content, str) else content
        (folder / student / name).write_bytes(data)


def hand_in_hostile(folder: Path, tricks: Iterable[Trick], file: str) -> list[str]:
    """Hand in hostile submissions under the name that an exercise expects."""
    names = []
    for trick in tricks:
        hand_in(folder, trick.name, {file: kit() + trick.text})
        names.append(trick.name)
    return names
