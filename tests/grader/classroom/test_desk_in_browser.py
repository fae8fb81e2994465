"""`course desk` in a real Chromium: two assistants at once, hostile students, no axe violation."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest
from desk_client import open_desk
from fake_class import FILE, SLUG
from marked_class import judged, points

from grader.classroom.desk.asked import RUBRIC, request, text_of
from grader.classroom.desk.marking import reading

pytestmark = pytest.mark.long
NAME = "<script>pwned=1<!script>\u202eevil \x1b[31mred"
CODE = (
    "import rclpy  # </code></script><script>window.pwned=1</script>\n\u202e# \x1b[2J evil\nx = 1\n"
)
ASKED = f"Student: bob\nExercise: {SLUG}\nPlease look at: <img src=x onerror=window.pwned=1>"
# A page that got into the feedback, and tries all that a page can
HOSTILE = """<!DOCTYPE html><title>x</title><h1>hostile</h1>
<form method=post action=/change id=f><input name=kind value=score></form><pre id=said></pre>
<script>
const said = document.getElementById('said');
const tell = (what) => (value) => said.append(what + ': ' + value + '\\n');
try { tell('cookie')(document.cookie) } catch (e) { tell('cookie')('refused') }
try { tell('parent')(parent.document.title) } catch (e) { tell('parent')('refused') }
try { tell('top')(top.location.href = '/marks') } catch (e) { tell('top')('refused') }
fetch('/').then((r) => r.text()).then(tell('fetch'), () => tell('fetch')('refused'));
fetch('/change', { method: 'POST', body: 'kind=score', mode: 'no-cors', credentials: 'include' })
  .then(() => tell('post')('sent'), () => tell('post')('refused'));
try { document.getElementById('f').submit() } catch (e) { tell('form')('refused') }
tell('popup')(window.open('/') === null ? 'refused' : 'open');
</script>
"""


@pytest.fixture
def out(grade_class: Any, handed_in: Path, tmp_path: Path) -> Path:
    """A class of four, of whom one is hostile."""
    (handed_in / NAME).mkdir()
    (handed_in / NAME / FILE).write_text(CODE)
    grade_class(judged)
    (tmp_path / "out" / RUBRIC).write_text('[points]\n"Names say <b>what</b>" = 4\n')
    return tmp_path / "out"


@pytest.fixture
def person(browser: Any, out: Path) -> Iterator[Callable[..., Any]]:
    """Open the desk as somebody, in a browser of their own."""
    contexts = []
    with open_desk(out, "Ada", "Ben") as addresses:

        def enter(name: str, **options: Any) -> Any:
            contexts.append(browser.new_context(**options))
            page = contexts[-1].new_page()
            page.goto(addresses[name])
            page.wait_for_url(lambda url: url.endswith("/"))
            page.base = addresses[name].partition("/enter")[0]
            return page

        yield enter
        for context in contexts:
            context.close()


def test_two_assistants_at_once(person: Callable[..., Any], out: Path) -> None:
    ada, ben = person("Ada"), person("Ben")
    for page, given in ((ada, "80"), (ben, "60")):
        page.get_by_role("link", name="ann, Obstacle avoidance: 70").click()
        page.get_by_text("All points").click()
        form = page.get_by_role("form", name="All points")
        form.get_by_label("Points, of 100").fill(given)
        form.get_by_label("Why").fill("looked at it")
    for page in (ada, ben):
        page.get_by_role("form", name="All points").get_by_role("button").click()
    assert "ann obstacle_avoidance 70 → 80" in ada.inner_text("main")
    ada.get_by_role("button", name="Write it").click()
    ada.get_by_text("1 score changed").wait_for()
    ben.get_by_role("button", name="Write it").click()
    ben.get_by_role("heading", name="Not written").wait_for()
    assert "Entry 1, Ada" in ben.inner_text("main")
    assert points(out)["ann"] == "80"
    # a comment on a line that is chosen with the keyboard
    ben.get_by_role("link", name="Open the page anew").click()
    ben.get_by_label("line 1", exact=True).check(force=True)
    ben.get_by_label("Comment on the chosen line").fill("Which <b>topic</b>?")
    ben.get_by_role("button", name="Comment").click()
    ben.get_by_role("link", name="Back").click()
    assert "Which <b>topic</b>?" in ben.locator(".remark").inner_text()
    with reading(out) as class_:
        assert [entry.who for entry in class_.entries] == ["Ada", "Ben"]


def test_hostile_students_stay_text_and_axe_is_content(
    person: Callable[..., Any], out: Path, axe: Callable[[Any], list[str]]
) -> None:
    with reading(out) as class_:
        (student,) = set(class_.students) - {"ann", "bob", "eve"}
    for scheme, width in (("light", 1280), ("dark", 360)):
        page = person("Ada", color_scheme=scheme, viewport={"width": width, "height": 800},
                      bypass_csp=True)  # fmt: skip
        complaints: list[str] = []
        page.on("pageerror", lambda error, to=complaints: to.append(str(error)))
        if scheme == "light":
            page.goto(f"{page.base}/requests")
            page.get_by_label("Text").fill(ASKED)
            page.get_by_role("button", name="Read").click()
        where = f"/student/{quote(student)}/{SLUG}"
        for path in ("/", "/held", "/requests", "/marks", where):
            page.goto(page.base + path)
            for part in page.locator("details").all():
                part.evaluate("(e) => { e.open = true }")
            assert axe(page) == [], path
            assert page.evaluate("document.documentElement.scrollWidth") <= width, path
            assert page.evaluate("window.pwned") is None
            assert "\u202e" not in page.inner_text("body") and "\x1b" not in page.inner_text("body")
        assert "</code></script><script>window.pwned=1" in page.locator(".code").inner_text()
        assert page.locator("img").count() == 0 and complaints == []


def test_the_feedback_page_makes_what_the_desk_reads(
    open_file: Callable[..., Any], axe: Callable[[Any], list[str]], out: Path
) -> None:
    page = open_file(out / f"feedback/ann/{SLUG}.html", bypass_csp=True, color_scheme="dark")
    page.get_by_text("Ask a person to look again").click()
    page.locator(".ask select").select_option("slow_zone")
    page.get_by_label("Moment").fill("2.25")
    page.get_by_label("What is wrong").fill("It stood \u202estill,\nStudent: eve <b>")
    text = page.get_by_label("Your text").input_value()
    with page.expect_download() as saved:
        page.get_by_role("button", name="Save").click()
    assert text_of(saved.value.path()) == text
    with reading(out) as class_:
        made = request(class_, text)
    assert (made.whom.students, made.check, made.moment) == (("ann",), "slow_zone", 2.25)
    assert made.words == "It stood still, Student: eve <b>"
    assert axe(page) == []


def test_a_students_page_does_not_reach_the_desk(person: Callable[..., Any], out: Path) -> None:
    (out / f"feedback/ann/{SLUG}.html").write_text(HOSTILE)
    ada = person("Ada")
    ada.goto(f"{ada.base}/student/ann/{SLUG}")
    frame = ada.frame_locator("iframe")
    for what in ("cookie", "parent", "top", "fetch", "post", "popup"):
        frame.locator("#said", has_text=f"{what}: refused").wait_for()
    assert ada.url.endswith(f"/student/ann/{SLUG}")
    assert frame.locator("h1").inner_text() == "hostile"  # it sent no form
    ada.goto(f"{ada.base}/replay/ann/{SLUG}")  # alone it may leave, and comes as a stranger
    ada.get_by_text("From another site").wait_for()
    # another page of this machine, by a port of its own
    elsewhere = person("Ben").context.new_page()
    elsewhere.route("http://127.0.0.1:1/**", lambda route: route.fulfill(
        body=f"<form method=post action={ada.base}/change><input name=kind value=score>"
        "<button>go</button></form>", content_type="text/html"))  # fmt: skip
    elsewhere.goto("http://127.0.0.1:1/")
    elsewhere.get_by_role("button").click()
    assert "From another site" in elsewhere.inner_text("body")
    with reading(out) as class_:
        assert class_.entries == []
