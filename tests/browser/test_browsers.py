"""What runs in a browser is asked of it: a page says it before anything is opened, and it is so."""

import json
import shutil
import tomllib
from pathlib import Path

import pytest
from browsers import BROWSERS, SAVED
from served_site import served

from grader.course.exercises import ROOT, all_exercises, find_exercise
from workspace.plan import plan

MADE = ROOT / "build" / "workspace" / "manifest.json"
WITH = "Runs here: 57 of the 100 points are judged; the installed course judges all of them."
WITHOUT = (
    "Needs JSPI (threads in a page), which this browser hasn\N{RIGHT SINGLE QUOTATION MARK}t: 53 of"
)
ROW = '<p class="runs-here" data-points="100" data-here="57" data-alone="{}"></p>'
THREADS = "'Suspending' in WebAssembly"
WAIT = "new Promise((tell) => {{ const look = () => {{ {}; setTimeout(look, 50); }}; look(); }})"
ROWS = WAIT.format("""if (document.body?.dataset.workspace)
  return tell([...document.querySelectorAll('.runs-here')].map((row) => row.textContent))""")
SETTLED = WAIT.format("""const settled = 'dialog.workspace:not([aria-busy=true]) .ws-status';
  const said = document.querySelector(settled)?.innerText; if (said) return tell(said)""")
FOUND = """Object.fromEntries([...document.querySelectorAll('.ws-list li')].map((row) =>
  [row.dataset.check, row.dataset.outcome]))"""
SHOW = """(document.querySelectorAll('.ws-files button')[{}]?.click(),
  document.querySelector('.ws-text:not([hidden]) .cm-content').focus())"""
PUT = "document.execCommand('insertText', false, {})"  # as an input method does
TYPED = "# and by keys: [(é)]"
BY_HAND = """(document.querySelectorAll('.ws-place input').forEach((each) => {{ each.value = 2; }}),
  [...document.querySelectorAll('.ws-hand button')]
  .find((button) => button.textContent.startsWith({})).click())"""
SAVE = SAVED.replace("CLICK", BY_HAND.format("'Save'"))
MEASURED = ("callback_time",)  # by the wall clock: undecided on a busy machine


@pytest.mark.quick
@pytest.mark.parametrize("name", BROWSERS)
def test_a_page_says_what_runs_in_this_browser(name: str, tmp_path: Path) -> None:
    site = shutil.copytree(ROOT / "workspace" / "web", tmp_path / "site")
    page = f'{ROW.format(57)}{ROW.format(53)}<script defer src="start.js"></script>'
    (site / "page.html").write_text(page, "utf-8")
    with served(site, tmp_path / "served") as address, BROWSERS[name](tmp_path / "own") as tab:
        tab.open(f"{address}/page.html")
        found, threads = tab.value(ROWS), tab.value(THREADS)
    assert found[0] == WITH
    assert found[1].startswith(WITH if threads else WITHOUT)


@pytest.mark.skipif(not MADE.is_file(), reason="no workspace here: run `make workspace`")
@pytest.mark.parametrize("name", BROWSERS)
@pytest.mark.parametrize("slug", [each.slug for each in all_exercises()])
def test_a_reference_that_is_typed_in_wins_what_the_page_says(
    address: str, name: str, slug: str, tmp_path: Path
) -> None:
    exercise, made = find_exercise(slug), plan(find_exercise(slug))
    with BROWSERS[name](tmp_path / "own") as tab:
        tab.open(f"{address}/exercises/index.html")
        said, threads = tab.value(ROWS)[exercise.number - 1], tab.value(THREADS)
        tab.open(f"{address}/exercises/{slug}/README.html#workspace")
        ready = tab.value(SETTLED)
        for number, file in enumerate(exercise.files):
            text = (exercise.solutions / file).read_text("utf-8")
            tab.value(SHOW.format(number))
            tab.press("Control", "a")
            tab.value(PUT.format(json.dumps(text)))
        tab.type(TYPED)
        kept = tab.value(f"JSON.parse(localStorage['course-workspace:{slug}']).text")
        tab.press("Control", "Shift", "Enter")
        ended, found = tab.value(SETTLED), tab.value(FOUND)
        (tmp_path / "checked.png").write_bytes(tab.picture())
        if made["race"]:
            tab.value("document.querySelector('.ws-racing button').click()")
            assert tab.value(SETTLED) == "Race: 3 of 3 worlds finished."
            tab.press("Control", "Enter")
            tab.value(SETTLED)
            sees = slug != "goal_seeking"  # or hears goals
            tab.value(BY_HAND.format("'Put a box'" if sees else "'Send this goal'"))
            there = "a box at (2.00, 2.00), from the start" if sees else "goal (2.00, 2.00)"
            assert there in tab.value(SETTLED)
            scenario = tomllib.loads(tab.value(SAVE))
            done = scenario["world"]["boxes"] if sees else scenario["script"]
            assert done[-1]["center" if sees else "goal"][:2] == [2.0, 2.0]
    assert kept.endswith(text + TYPED)
    judged = {c["id"]: c["points"] for c in made["checks"]
              if c["scenarios"] and (threads or c["alone"])}  # fmt: skip
    points, most = sum(judged.values()), exercise.max_points
    assert (f" {points} of the {most} " if points < most else f"all {most} points") in said
    if not judged:
        assert "needs threads" in ready
        assert ended == ready
        return
    assert ready.startswith("Ready.")
    passed = [check for check, outcome in found.items() if outcome == "pass"]
    assert set(passed) <= set(judged)
    left = {check: found[check] for check in judged if check not in passed}
    assert left in ({}, dict.fromkeys(MEASURED, "inconclusive"))
    assert ended.startswith(f"{sum(judged[check] for check in passed)} of ")
