"""`course progress`: a file of the page's is laid into folders, and saved from them."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest

from grader.cli import run
from grader.cli.progress import MOST
from grader.course.begin import begin
from grader.course.exercises import find_exercise

SLUG, FILE = "obstacle_avoidance", "obstacle_avoidance_agent.py"
OWN = 'title = "Mine"\nextends = "avoid_cart"\nseed = 7\n'
AT = "2026-11-28T09:30:00.123Z"
BEST = {"lap": {"world": "w", "figure": 9.5, "median": None}, "track": {"t": [0.0], "x": [1.5]}}


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def saved(**work: Any) -> dict[str, Any]:
    return {"format": "course-progress", "version": 1, "at": AT, "exercises": {SLUG: work}}


def progress(doc: Any, *more: str) -> int:
    Path("p.json").write_text(doc if isinstance(doc, str) else json.dumps(doc), "utf-8")
    return run(["progress", "p.json", *more])


def test_what_came_goes_back_with_all_versions(here: Path) -> None:
    older = {"files": {FILE: "older = 1\n"}, "points": "85 of 100", "at": AT}
    more = {"green": older, "scenarios": {"m.toml": OWN}, "race": {"w": BEST}}
    assert progress(saved(files={FILE: "new = 2\n"}, versions=[older], **more)) == 0
    folder = here / SLUG
    assert (folder / FILE).read_text() == "new = 2\n"
    assert (folder / "m.toml").read_text() == OWN
    assert (folder / "README.md").is_file()
    (folder / FILE).write_text("newer = 3\n")
    assert run(["progress", "p.json", "--export"]) == 0
    work = json.loads(Path("p.json").read_text())["exercises"][SLUG]
    assert work["files"] == {FILE: "newer = 3\n"}
    assert [(v["files"][FILE], v["points"]) for v in work["versions"]] == [
        ("new = 2\n", "put aside"), ("older = 1\n", "85 of 100"),
    ]  # fmt: skip
    assert work["green"]["files"] == older["files"]
    assert (work["scenarios"], work["race"]) == ({"m.toml": OWN}, {"w": BEST})


def test_nobodys_work_is_replaced(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = begin(find_exercise(SLUG), here)
    (folder / FILE).write_text("mine\n")
    (folder / "m.toml").symlink_to(here / "elsewhere")
    for _ in range(2):  # once more, and nothing comes
        assert progress(saved(files={FILE: "theirs\n"}, scenarios={"m.toml": OWN})) == 0
    assert "Everything in it is here already" in capsys.readouterr().out
    assert (folder / FILE).read_text() == "mine\n"
    assert (folder / FILE.replace(".py", "_imported.py")).read_text() == "theirs\n"
    assert (folder / "m_imported.toml").read_text() == OWN
    assert not os.path.lexists(here / "elsewhere")
    assert progress(saved(files={FILE: "others\n"})) == 0
    assert (folder / FILE.replace(".py", "_imported2.py")).read_text() == "others\n"


def test_what_belongs_to_no_exercise_is_named_and_left_out(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    doc = saved(files={"../../evil.py": "1", FILE: "mine\n"}, scenarios={"no.toml": "world = 1"})
    doc["exercises"]["../up"] = {"files": {"up.py": "1"}}
    assert progress(doc) == 0
    said = capsys.readouterr().out
    for name in ("'../up', which is no", f"{SLUG}/../../evil.py, which is no", f"{SLUG}/no.toml: "):
        assert f"left out: {name}" in said
    assert {each.name for each in here.iterdir()} == {"p.json", SLUG}
    assert (here / SLUG / FILE).read_text() == "mine\n"
    assert not (here / SLUG / "no.toml").exists()


TEXT = {"files": {FILE: "x"}, "points": "", "at": AT}


@pytest.mark.parametrize(
    "doc",
    [
        "", "[]", "[" * 100_000, '{"format": "course-progress"}', saved(files={FILE: 5}),
        {**saved(), "version": 2}, {**saved(), "more": 1}, {**saved(), "at": "yesterday"},
        saved(files={FILE: "x" * (2**20 + 1)}), saved(versions=[TEXT] * 21), saved(text="x"),
        saved(versions=[{**TEXT, "at": "2026-13-01T00:00:00Z"}]), saved(green=[]),
        saved(race={"w": {**BEST, "track": {"t": ["x"]}}}),
        saved(scenarios={"../m.toml": OWN}), saved(scenarios={"__proto__": OWN}),
        saved(scenarios={f"m{i}.toml": OWN for i in range(51)}), " " * (MOST + 1),
    ],
)  # fmt: skip
def test_another_form_is_refused_and_nothing_written(
    here: Path, doc: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    if isinstance(doc, dict) and SLUG in doc["exercises"]:
        doc["exercises"] = {"three_nodes": {"files": {"guard.py": "x"}}, **doc["exercises"]}
    assert progress(doc) == 2
    assert "p.json: expected a file that the page's *Progress* or" in capsys.readouterr().err
    assert [each.name for each in here.iterdir()] == ["p.json"]


def test_what_is_no_work_is_not_saved(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for slug in (SLUG, "three_nodes", "trend_memory"):
        begin(find_exercise(slug), here)
    (here / "three_nodes" / "guard.py").write_bytes(b"one = 1\r\n")
    (here / "trend_memory" / "trend_agent.py").write_bytes(b"\xff")
    (here / SLUG / "my.toml").symlink_to(here / "three_nodes" / "guard.py")
    assert run(["progress", "p.json", "--export"]) == 0
    said = capsys.readouterr().out
    assert said.count("left out:") == 2
    assert "work in three_nodes\n" in said
    assert "p.json is new: earlier versions are in the file that the page has saved" in said
    works = json.loads(Path("p.json").read_text())["exercises"]
    assert works["three_nodes"]["files"]["guard.py"] == "one = 1\n"
    capsys.readouterr()
    assert progress("no progress", "--export") == 2
    assert "got one that begins with “no progress”; choose another" in capsys.readouterr().err
    for other, words in (("", "got an empty one"), ("\x89PNG\0", "got one that is no text")):
        assert progress(other) == 2
        assert words in capsys.readouterr().err
    assert progress(json.dumps(saved())[:-1]) == 2
    assert "; save it again where it was made" in capsys.readouterr().err
    assert progress("no progress", "--export") == 2
    assert Path("p.json").read_text() == "no progress"
