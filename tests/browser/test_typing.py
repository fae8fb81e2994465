"""What is typed into the page's editor, key by key, is what stands there.

No completion changes a word that is finished. Without `make workspace` these tests are skipped.
"""

import io
import json
import tokenize
from collections.abc import Callable
from typing import Any

import payloads
import pytest
from served_site import typed

from grader.course.exercises import ROOT, Exercise, all_exercises, find_exercise
from grader.report.page import page_html

MADE = ROOT / "build" / "workspace" / "manifest.json"
SLUG = "obstacle_avoidance"
PACE = 150  # [ms] from key to key: time for a list to open; Enter takes nothing in its first 75
FAST = 7  # [ms]
NO_PYTHON = "delete globalThis.WebAssembly"  # the editor is the real one, and nothing else starts
KEPT = "(slug) => JSON.parse(localStorage.getItem(`course-workspace:${slug}`)).text"
FRAME = """(place, html) => { const frame = document.createElement('iframe');
  Object.assign(frame, { sandbox: 'allow-scripts', srcdoc: html });
  place.replaceChildren(frame); }"""
FOCUSED = "document.activeElement.closest('.cm-editor') !== null"
BEFORE = """\
def f(distance, speed, usable, reading, index):
    for x in y:
        if z:
            """

pytestmark = pytest.mark.skipif(
    not MADE.is_file(), reason="the site has no workspace here: run `make workspace`"
)


@pytest.fixture
def open_editor(open_served: Any) -> Callable[..., Any]:
    """Open an exercise's editor."""

    def open_(slug: str = SLUG, script: str = "") -> Any:
        page = open_served(f"exercises/{slug}/README.html#workspace", f"{NO_PYTHON}; {script}")
        page.locator(".cm-content:visible").wait_for()
        return page

    return open_


def empty(page: Any) -> None:
    page.locator(".cm-content:visible").focus()
    page.keyboard.press("Control+A")
    page.keyboard.press("Delete")


class Hands:
    """Type at a person's pace, on a clock of the page's own: nobody waits."""

    def __init__(self, page: Any) -> None:
        self.page = page
        page.clock.install()
        page.clock.pause_at(page.evaluate("Date.now() + 1000"))

    def type(self, text: str) -> None:
        for each in text:
            self.page.keyboard.type(each)
            self.page.clock.run_for(PACE)

    def press(self, *keys: str) -> None:
        for key in keys:
            self.page.keyboard.press(key)
            self.page.clock.run_for(PACE)


class FastHands(Hands):
    def __init__(self, page: Any) -> None:
        self.page = page

    def type(self, text: str) -> None:
        self.page.keyboard.type(text, delay=FAST)

    def press(self, *keys: str) -> None:
        for key in keys:
            self.page.keyboard.press(key, delay=FAST)


def unfinished(text: str) -> set[int]:
    """Return the lines at whose end a bracket or a string is open; the first is 1."""
    rows, depth = set(), 0
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        rows |= set(range(token.start[0], token.end[0]))
        if token.type == tokenize.OP:
            depth += (token.string in "([{") - (token.string in ")]}")
        if token.type == tokenize.NL and depth:
            rows.add(token.start[0])
        if token.type == tokenize.COMMENT and token.string.count("(") > token.string.count(")"):
            rows.add(token.start[0])  # the editor closes it there, too
    return rows


def write(hands: Hands, text: str) -> None:
    """Type a file as a person does, who sees what the editor indents and closes on its own."""
    empty(hands.page)
    lines, is_open = text.split("\n"), unfinished(text)
    for number, line in enumerate(lines, 1):
        code = line.lstrip()
        wanted = len(line) - len(code)
        while code or number == len(lines):
            found = len(hands.page.locator(".cm-activeLine:visible").text_content())
            if found <= wanted:
                hands.type(" " * (wanted - found))
                break
            hands.press("Backspace")
        hands.type(code)
        if number in is_open:  # what closes it stands behind already
            hands.press("Control+Shift+End", "Delete")
        if number < len(lines):
            hands.press("Enter")


def write_reference(hands: Hands, exercise: Exercise) -> None:
    """Type an exercise's reference, each file into its tab; the browser keeps what was typed."""
    texts = [(exercise.solutions / name).read_text("utf-8") for name in exercise.files]
    for number, text in enumerate(texts):
        if texts[1:]:
            hands.page.locator(".ws-files button").nth(number).click()
        write(hands, text)
    kept = hands.page.evaluate(KEPT, exercise.slug)
    if texts[1:]:
        texts = [f"\f# {name}\n{text}" for name, text in zip(exercise.files, texts, strict=True)]
    assert kept == "\n".join(texts)


def test_a_reference_that_is_typed_at_a_persons_pace_is_kept_as_it_is(
    open_editor: Callable[..., Any],
) -> None:
    write_reference(Hands(open_editor()), find_exercise(SLUG))


def test_no_list_opens_in_a_comment(open_editor: Callable[..., Any]) -> None:
    hands = Hands(open_editor())
    empty(hands.page)
    hands.type("# too.")
    assert hands.page.locator(".cm-tooltip-autocomplete").count() == 0
    hands.press("Enter")
    hands.type("self.")
    assert hands.page.locator(".cm-tooltip-autocomplete").count() == 1


@pytest.mark.long
@pytest.mark.parametrize("slug", [each.slug for each in all_exercises() if each.slug != SLUG])
def test_a_reference_that_is_typed_fast_is_kept_as_it_is(
    open_editor: Callable[..., Any], slug: str
) -> None:
    write_reference(FastHands(open_editor(slug)), find_exercise(slug))


def test_enter_after_a_finished_word_is_a_new_line(open_editor: Callable[..., Any]) -> None:
    page = open_editor()
    hands = Hands(page)
    different = {}
    for line in (
        "continue", "break", "pass", "return", "raise", "return None", "return distance",
        "return speed", "else:", "return True", "twist = Twist()", "usable.append(reading)",
        "import time", "return min", "return 0.0", "x = index", "not", "lambda", "elif", "try",
        "for", "import", "raise NotImplementedError", "node.crea", "conti",
    ):  # fmt: skip
        empty(page)
        page.keyboard.insert_text(BEFORE)
        hands.type(line)
        hands.press("Enter")
        found = page.evaluate(KEPT, SLUG).removeprefix(BEFORE.rstrip(" "))
        if [each.strip() for each in found.split("\n")] != [line, ""]:
            different[line] = found
    assert different == {}


def test_enter_takes_what_was_chosen_until_more_is_typed(open_editor: Callable[..., Any]) -> None:
    page = open_editor()
    hands = Hands(page)
    for keys, wanted in {
        ("ArrowDown", "Enter"): "continue",
        ("Control+Space", "Enter"): "continue",
        ("ArrowDown", "t", "Enter"): "cont\n",
        ("ArrowDown", "Backspace", "Enter"): "co\n",
        ("ArrowDown", "Escape", "Enter"): "con\n",
        ("Escape", "Control+Space", "Enter"): "con\n",
        ("Escape", "Control+Space", "Control+Space", "Enter"): "continue",
    }.items():
        empty(page)
        hands.type("con")
        hands.press(*keys)
        assert page.evaluate(KEPT, SLUG) == wanted, keys


def test_escape_never_leaves_the_editor_and_tab_does(open_editor: Callable[..., Any]) -> None:
    page = open_editor()
    empty(page)
    hands = Hands(page)
    hands.type("con")
    hands.press("Escape", "Escape", "Escape", "Control+f", "Escape", "Escape")
    assert page.evaluate(FOCUSED)
    hands.press("x")
    assert typed(page) == "conx"
    hands.press("Tab")
    assert not page.evaluate(FOCUSED)
    hands.press("Shift+Tab")
    assert page.evaluate(FOCUSED)
    hands.press("Tab", "Escape")
    assert not page.locator("dialog.workspace").is_visible()


def test_shortcuts_work_wherever_the_focus_is(open_editor: Callable[..., Any]) -> None:
    page = open_editor()
    empty(page)
    html = page_html(payloads.drive_page() | {"embedded": True})
    page.locator(".ws-replay").evaluate(FRAME, html)
    replay = page.frame_locator(".ws-replay iframe").locator(".map")
    status, nothing = page.locator(".ws-status"), page.locator("body")
    for place in (*map(page.locator, (".cm-content:visible", "#ws-scenario", ".ws-close")), replay,
                  nothing):  # fmt: skip
        for keys in ("Control+Enter", "Control+Shift+Enter"):
            status.evaluate("(each) => each.replaceChildren()")
            if place is nothing:
                page.evaluate("document.activeElement.blur()")
            else:
                place.focus()
            page.keyboard.press(keys)
            status.filter(has_text="begins with the skeleton again.").wait_for()
    assert page.locator("dialog.workspace").is_visible()
    page.locator("#ws-scenario").focus()
    for keys, pane in (("F6", ".cm-content"), ("F6", ".ws-replay iframe"), ("F6", ".ws-result"),
                       ("F6", ".cm-content"), ("Shift+F6", ".ws-result")):  # fmt: skip
        page.keyboard.press(keys)
        page.wait_for_function("(pane) => document.activeElement.matches(pane)", arg=pane)


def test_what_version_1_0_0_kept_is_found_again(open_editor: Callable[..., Any]) -> None:
    at = "2026-03-01T10:00:00.000Z"
    green = {"text": "# all\n", "points": "100 of 100", "at": at}
    versions = [{"text": "# some\n", "points": "95 of 100", "at": at},
                {"text": "# aside\n", "points": "put aside", "at": at}, green]  # fmt: skip
    state = {"text": "# mine\n", "versions": versions, "green": green}
    script = f"localStorage.setItem('course-workspace:{SLUG}', {json.dumps(json.dumps(state))})"
    page = open_editor(script=script)
    assert typed(page).strip() == "# mine"
    listed = page.get_by_label("Earlier versions")
    points = [each.partition(": ")[2] for each in listed.locator("option").all_inner_texts()[1:]]
    assert points == ["95 of 100", "put aside", "100 of 100"]
    listed.select_option(index=1)
    assert typed(page).strip() == "# some"
    page.get_by_role("button", name="Changes").click()
    assert page.locator(".ws-changes [data-sign='-']").inner_text().strip() == "- # all"
