"""A progress file from anywhere: what is loaded is added to what is here, or refused as a whole."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from browsers import BROWSERS, SAVED
from served_site import served

from grader.course.exercises import ROOT

MADE = ROOT / "build" / "workspace" / "manifest.json"
SLUG, FILE, OTHER = "obstacle_avoidance", "obstacle_avoidance_agent.py", "three_nodes"
OWN = 'title = "Mine"\nextends = "avoid_cart"\nseed = 7\n'
AT = "2026-11-28T09:30:00.123Z"
BEST = {"lap": {"world": "w", "figure": 9.5, "median": None}, "track": {"t": [0.5], "x": [1.5]}}
HOSTILE = {"__proto__": {}, "no_such": {}, OTHER: {"files": {"../up": "x", "__proto__": "y"}}}
LOAD = """(async () => {
  document.querySelector('.ws-close').previousElementSibling.click();
  const soon = () => new Promise((next) => { setTimeout(next, 20); });
  while (!document.querySelector('.ws-progress[open]')) await soon();
  const input = document.querySelector('.ws-progress input');
  const made = new DataTransfer();
  made.items.add(new File([TEXT], NAME));
  input.files = made.files;
  const said = document.querySelector('.ws-progress [role=status]');
  said.replaceChildren();
  input.dispatchEvent(new Event('change'));
  while (!said.textContent) await soon();
  return said.innerText;
})()"""
SAVE = SAVED.replace("CLICK", "document.querySelector('.ws-progress button').click()")
FULL = """(() => { const set = Storage.prototype.setItem;
  Storage.prototype.setItem = function full(key, text) {
    if (text.includes('too much')) throw new DOMException('no', 'QuotaExceededError');
    return set.call(this, key, text);
  }; })()"""


def doc(works: dict[str, Any]) -> dict[str, Any]:
    return {"format": "course-progress", "version": 1, "at": AT, "exercises": works}


def version(text: str, points: str = "1 of 100", at: str = AT) -> dict[str, Any]:
    return {"files": {FILE: text}, "points": points, "at": at}


@pytest.mark.skipif(not MADE.is_file(), reason="no workspace here: run `make workspace`")
@pytest.mark.parametrize("name", BROWSERS)
def test_what_is_loaded_is_added_or_refused_as_a_whole(
    site: Path, tmp_path: Path, name: str
) -> None:
    mine = [{"text": f"v{i}", "points": "", "at": f"2026-10-{10 + i}T00:00:00Z"} for i in range(20)]
    shelf: dict[str, Any] = {
        "text": "mine",
        "versions": mine,
        "scenarios": {"m.toml": "x"},
        "more": 1,
        "race": {each: {"lap": {"figure": t}} for each, t in {"w": 9.4, "v": 9.6}.items()},
    }
    put = f"localStorage['course-workspace:{SLUG}'] = {json.dumps(json.dumps(shelf))}"
    came = {"files": {FILE: "theirs"}, "versions": [version("v3", "9 of 100"), version("old")],
            "green": version("green"), "scenarios": {"m.toml": OWN, "n.toml": "x"},
            "race": {"w": BEST, "v": BEST}}  # fmt: skip
    with served(site, tmp_path / "served") as address, BROWSERS[name](tmp_path / "own") as tab:
        place = f"{address}/exercises/{SLUG}/README.html#workspace"
        tab.open(place)
        tab.value(put)
        tab.open(f"{address}/index.html")
        tab.open(place)
        tab.value("(async () => { while (!document.querySelector('.cm-content')) "
                  "await new Promise((next) => { setTimeout(next, 50); }); })()")  # fmt: skip

        def say(content: Any, file: str = "p.json") -> str:
            text = content if isinstance(content, str) else json.dumps(content)
            load = LOAD.replace("NAME", json.dumps(file))
            return str(tab.value(load.replace("TEXT", json.dumps(text))))

        def kept(slug: str = SLUG) -> Any:
            return tab.value(f"localStorage['course-workspace:{slug}'] ?? null")

        before, first = kept(), {OTHER: {"files": {"driver.py": "x"}}}
        for content, said in (
            ("", "is empty"), ("[" * 100_000, "begins with “[[["), ("[]", "begins with “[]”"),
            ('{"a": 1, "b"', "p.json: nothing was loaded: expected course-progress.json"),
            (json.dumps(doc({}))[:-1], "cut on its way"),
            ({**doc({}), "version": 2}, "version: expected 1;"), (doc({SLUG: []}), "an object"),
            (doc(first | {SLUG: {"files": {FILE: 5}}}), f"{SLUG}, {FILE}: expected a text"),
            (doc(first | {SLUG: {"text": ""}}), "expected only files, versions"),
            (doc({SLUG: {"versions": [version("x")] * 21}}), "a list of at most 20"),
            (doc({SLUG: {"green": version("x", at="2026-13-01T00:00:00Z")}}), "expected a date"),
            (doc({SLUG: {"race": {"w": {**BEST, "track": {"t": ["x"]}}}}}), "at most 2000 numbers"),
            (doc({SLUG: {"scenarios": {"__proto__.toml": OWN}}}), "names such as"),
            (" " * (2**24 + 1), "at most 16 MB; it has 16.0 MB"),
        ):  # fmt: skip
            assert said in say(content), content
        assert (kept(), kept(OTHER)) == (before, None)
        tab.value(FULL)
        full = {OTHER: {"files": {"driver.py": "x"}}, SLUG: {"files": {FILE: "too much"}}}
        assert "no room for it" in say(doc(full))
        assert (kept(), kept(OTHER)) == (before, None)

        said = say(doc(HOSTILE | {SLUG: came}))
        for each in ("__proto__", "no_such", f"{OTHER}, ../up", f"{OTHER}, __proto__"):
            assert f"no such exercise or file: {each}" in said
        assert "your text stays" in said
        assert "so the 2 oldest went" in said
        now = json.loads(kept())
        assert (now["text"], now["green"]["text"], now["more"]) == ("mine", "green", 1)
        points = {each["text"]: each["points"] for each in now["versions"]}
        assert (points["v3"], len(points)) == ("9 of 100", 20)
        assert points["theirs"].startswith("imported, from ")
        assert {"v0", "v1"}.isdisjoint(points)
        assert now["scenarios"] == {"m.toml": "x", "m_2.toml": OWN}
        assert now["race"] == {"w": BEST, "v": shelf["race"]["v"]}  # the longer way
        assert json.loads(kept(OTHER))["text"] is None
        for again in (doc({SLUG: came}), tab.value(SAVE)):
            say(again)
            assert json.loads(kept()) == now  # nothing more
        assert "at most 65536 characters" in say("#" * 65_537, "long.toml")
        assert json.loads(kept()) == now
        assert "Loaded: b_by_hand_1.toml." in say(OWN + "#", "<b>by hand (1).toml")
        assert json.loads(kept())["scenarios"]["b_by_hand_1.toml"] == OWN + "#"
        assert tab.value("document.querySelector('#ws-scenario').value") == "b_by_hand_1.toml"
