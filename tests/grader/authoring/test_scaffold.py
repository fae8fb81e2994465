"""`course new`: the files of a new exercise, and that none is written if one is in its way.

`tests/docs/test_walk.py` makes one, proves it, and runs `make lint` on it.
"""

import re
import shutil
import tomllib
from pathlib import Path

import msgspec
import pytest

from grader.authoring import scaffold as module
from grader.authoring.scaffold import LISTS, scaffold
from grader.course.exercises import ROOT, Exercise, all_exercises
from grader.errors import GraderError, InputError


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """A course of which only the lists are there."""
    for name in {"pyproject.toml", *(name for name, _, _ in LISTS)}:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    for folder in ("solutions", "docs", "notebooks/text", "sim/worlds", "sim/scenarios"):
        (tmp_path / folder).mkdir(parents=True, exist_ok=True)
        (tmp_path / folder / "kept.txt").write_text("")
    return tmp_path


def files(root: Path) -> dict[str, str]:
    return {
        path.relative_to(root).as_posix(): path.read_text("utf-8")
        for path in root.rglob("*")
        if path.is_file()
    }


def test_a_new_exercise_is_in_all_its_places(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = files(root)
    monkeypatch.setattr(module, "_generate", lambda made, root: None)
    made = scaffold("wait_and_see", root)
    after = files(root)
    assert made.number == max(exercise.number for exercise in all_exercises()) + 1
    new = {path.as_posix() for path in made.new}
    assert set(after) - set(before) == new
    assert {path.as_posix() for path in made.edited} == {name for name, _, _ in LISTS}
    about = tomllib.loads(after["exercises/wait_and_see/exercise.toml"])
    assert msgspec.convert(about, Exercise).max_points == 100
    assert "class WaitAndSeeAgent(Node)" in after["solutions/wait_and_see/wait_and_see_agent.py"]
    text = after[f"notebooks/text/{made.number}_wait_and_see/{made.number}_wait_and_see.md"]
    notes = re.findall(r"\(filled in: (.+)\)", text)
    assert notes == [
        "grader/notebook/bootstrap.py",
        "topics and tasks of exercises/wait_and_see/README.md",
        "solutions/wait_and_see/wait_and_see_agent.py",
        "exercises/wait_and_see/hints.md",
    ]
    assert not any("{{" in after[name].replace("{{class", "") for name in new)
    for name in {name for name, _, _ in LISTS}:
        added = set(after[name].splitlines()) - set(before[name].splitlines())
        assert added, name
        assert all("wait_and_see" in line or "Wait and see" in line for line in added)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("Stop-Line", "expected a name such as give_way"),
        ("../evil", "expected a name"),
        ("a" * 21, "at most 20 characters"),
        ("class", "a word of Python's own"),
        ("con", "a device's name on Windows"),
        ("goal_seeking", "too close to the exercise goal_seeking"),
        ("goal_seekings", "too close to the exercise goal_seeking"),
        ("random", "a module of Python's"),
        ("numpy", "a module of Python's or a library's"),
    ],
)
def test_a_name_that_will_not_do(root: Path, name: str, said: str) -> None:
    before = files(root)
    with pytest.raises(InputError, match=said):
        scaffold(name, root)
    assert files(root) == before


def test_nothing_is_written_if_something_is_in_its_way(root: Path) -> None:
    (root / "sim" / "scenarios" / "give_way_ahead.toml").write_text("")
    before = files(root)
    with pytest.raises(InputError, match=r"give_way_ahead\.toml is called so"):
        scaffold("give_way", root)
    assert files(root) == before
    (root / "README.md").write_text("# A course\n")
    before = files(root)
    with pytest.raises(GraderError, match=r"README\.md: no place"):
        scaffold("stop_sign", root)
    assert files(root) == before


@pytest.mark.parametrize("place", ["solutions/give_way", "exercises/give_way/README.md"])
def test_nothing_is_written_through_a_link(root: Path, tmp_path: Path, place: str) -> None:
    (root / place).parent.mkdir(parents=True, exist_ok=True)
    (root / place).symlink_to(tmp_path / "elsewhere")
    before = files(root)
    with pytest.raises(InputError, match=r"expected no link there; it leads to .*elsewhere"):
        scaffold("give_way", root)
    assert files(root) == before
    assert not (tmp_path / "elsewhere").exists()


def test_what_cannot_be_generated_is_said(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "SKELETONS", "no_such_module")
    with pytest.raises(GraderError, match=r"python -m no_such_module: .*No module named"):
        scaffold("give_way", root)


def test_only_in_a_checkout(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="expected a checkout"):
        scaffold("give_way", tmp_path)
