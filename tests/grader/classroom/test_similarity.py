"""Similar submissions: what the class report calls alike, and what it doesn't."""

from __future__ import annotations

import importlib.util
import random
import re
from pathlib import Path
from typing import Any

from grader.classroom.results.similarity import NOISE, WINDOW, fingerprints, similar_groups, tokens
from grader.classroom.row import StoredResult

_CLASSES = Path(__file__).resolve().parents[2] / "browser" / "classes.py"
_spec = importlib.util.spec_from_file_location("classes", _CLASSES)
assert _spec and _spec.loader
classes: Any = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(classes)

OBSTACLES = "obstacle_avoidance"


def check(id_: str, outcome: str, points: float = 10, **parts: Any) -> dict[str, Any]:
    won = points if outcome == "pass" else 0
    return {
        "id": id_, "title": f"The robot does {id_}.", "kind": "core", "outcome": outcome,
        "points": won, "max_points": points, "message": "", "expected": "", "actual": "",
        "time": None, "help": "", "scenario": None, **parts,
    }  # fmt: skip


def result(student: str, *checks: dict[str, Any], **parts: Any) -> StoredResult:
    judged = [c for c in checks if c["outcome"] not in ("error", "inconclusive", "unavailable")]
    grading = {
        "exercise": OBSTACLES,
        "file": "/home/prof/in/agent.py",
        "score": sum(c["points"] for c in checks),
        "max_score": sum(c["max_points"] for c in judged),
        "field_ready": None,
        "checks": list(checks),
        "recordings": [],
        "versions": {"python": "3.11.2"},
    }
    return classes.stored(student, OBSTACLES, grading if checks else None, **parts)


# --- similar submissions ------------------------------------------------------------------------


def renamed(source: bytes) -> bytes:
    """Other names, comments and line breaks, the same program."""
    text = re.sub(r"\bpart_(\d)", r"stage_\1", source.decode()).replace("scan", "reading")
    return text.replace("# ", "# mine: ").replace("\n        ", "\n\n        ").encode()


def test_renaming_hides_nothing_and_the_skeleton_is_no_similarity() -> None:
    original, other = classes.program(3), classes.program(4)
    texts = {
        "ada": {"a.py": original},
        "ben": {"a.py": renamed(original)},
        "chen": {"a.py": other},
        "dan": {"a.py": original + b"\n" + other[: len(other) // 9]},
    }
    groups = similar_groups(texts, {})
    assert [group.students for group in groups] == [("ada", "ben", "dan")]
    assert groups[0].similarity == 1.0
    assert not groups[0].identical
    del texts["dan"]  # what he added is a part of chen's
    assert similar_groups(texts, {"a.py": original}) == []


def test_winnowing_finds_every_match_that_is_long_enough() -> None:
    chance = random.Random(4)
    for _ in range(300):
        shared = [str(chance.random()) for _ in range(NOISE + WINDOW - 1)]
        one, other = (
            [str(chance.random()) for _ in range(chance.randrange(60))]
            + shared
            + [str(chance.random()) for _ in range(chance.randrange(60))]
            for _ in range(2)
        )
        assert fingerprints(one) & fingerprints(other)


def test_the_courses_own_solutions_are_not_similar() -> None:
    folder = Path(__file__).resolve().parents[3] / "solutions" / OBSTACLES
    files = [folder / "obstacle_avoidance_agent.py", *sorted(folder.glob("variants/*.py"))]
    texts = {file.stem: {"a.py": file.read_bytes()} for file in files}
    assert len(texts) > 5
    assert similar_groups(texts, {}) == []


def test_what_is_not_python_is_compared_by_words() -> None:
    for source in (b"", b"\x00\xff", b"def (", b"'''", b"\tif x:\n  y", b"# coding: nonsense\nx"):
        assert isinstance(fingerprints(tokens(source)), frozenset)


def test_what_half_the_class_has_is_common_ground() -> None:
    shared = classes.program(3)
    texts = {f"s{i}": {"a.py": shared + classes.program(100 + i)[17:]} for i in range(12)}
    assert similar_groups(texts, {}) == []
    assert len(similar_groups(dict(list(texts.items())[:2]), {})) <= 1
