"""The lesson's site: it builds without a warning, leads nowhere wrong, and needs no network."""

import html.parser
import re
from functools import cache
from pathlib import Path
from urllib.parse import unquote, urldefrag, urlparse

import pytest
from lesson_pages import LESSONS, PAGES, ROOT

from grader.authoring.lesson_replays import watched
from grader.authoring.pitfalls import PITFALLS

LOADS = {  # elements that fetch what an attribute names
    ("link", "href"), ("script", "src"), ("img", "src"), ("img", "srcset"), ("source", "src"),
    ("source", "srcset"), ("iframe", "src"), ("video", "src"), ("video", "poster"),
    ("audio", "src"), ("track", "src"), ("embed", "src"), ("object", "data"), ("input", "src"),
    ("use", "href"), ("use", "xlink:href"), ("image", "href"), ("image", "xlink:href"),
}  # fmt: skip
EXTERNAL = re.compile(r"(?i)^\s*(https?:)?//")
EXERCISES = sorted(file.parent.name for file in ROOT.glob("exercises/*/exercise.toml"))


class Page(html.parser.HTMLParser):
    """What a page links to, loads, and can be linked at."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.file = file
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.text = file.read_text("utf-8")
        self.feed(self.text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.anchors |= {given[name] for name in ("id", "name") if name in given}
        if tag in ("a", "area") and "href" in given:
            self.links.append(given["href"])
        for name, value in given.items():
            if (tag, name) in LOADS:
                if not (tag == "link" and given.get("rel") in ("canonical", "license")):
                    self.loads.append(value)
            elif name == "style":
                self.loads += css_loads(value)

    handle_startendtag = handle_starttag


def css_loads(css: str) -> list[str]:
    """Return what a style sheet fetches."""
    found = re.findall(r"url\(\s*['\"]?([^'\")]+)", css)
    return found + re.findall(r"@import\s+['\"]([^'\"]+)", css)


@cache
def replays() -> set[str]:
    """Return the replays that `make site` writes into the finished site."""
    names = {f"pitfalls/replays/{p.replay_of(node)}.html" for p in PITFALLS for node in p.nodes}
    return names | {f"replays/{name}.html" for name in watched()}


def dead_links(site: Path, pages: dict[str, Page]) -> list[str]:
    """Return the links within a site that lead nowhere."""
    dead = []
    for name, page in pages.items():
        for link in page.links:
            target, anchor = urldefrag(link)
            if urlparse(target).scheme in ("http", "https", "mailto"):
                continue
            path = unquote(target.partition("?")[0])  # JupyterLite is told of a notebook behind it
            file = (page.file.parent / path).resolve() if path else page.file.resolve()
            place = file.relative_to(site.resolve()).as_posix()
            if place in replays():
                continue
            if not file.is_file():
                dead.append(f"{name}: {link}")
            elif anchor and place in pages and unquote(anchor) not in pages[place].anchors:
                dead.append(f"{name}: {link} (no such place on the page)")
    return dead


def loads_of(site: Path, pages: dict[str, Page]) -> list[tuple[str, str]]:
    """Return (page or style sheet, what it fetches)."""
    loads = [(name, load) for name, page in pages.items() for load in page.loads]
    for name, page in pages.items():
        for css in re.findall(r"(?s)<style[^>]*>(.*?)</style>", page.text):
            loads += [(name, load) for load in css_loads(css)]
    for file in site.rglob("*.css"):
        place = file.relative_to(site).as_posix()
        loads += [(place, load) for load in css_loads(file.read_text("utf-8"))]
    return loads


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[str, Page]:
    return {file.relative_to(site).as_posix(): Page(file) for file in site.rglob("*.html")}


def test_every_page_is_there(pages: dict[str, Page]) -> None:
    assert {f"{page.stem}.html" for page in PAGES} <= set(pages)
    for name in EXERCISES:
        assert f"exercises/{name}/README.html" in pages
        assert f"exercises/{name}/hints.html" in pages


def test_no_link_is_dead(site: Path, pages: dict[str, Page]) -> None:
    assert dead_links(site, pages) == []
    assert sum(len(page.links) for page in pages.values()) > 1000


def test_nothing_is_loaded_from_elsewhere(site: Path, pages: dict[str, Page]) -> None:
    loads = loads_of(site, pages)
    assert len(loads) > 100
    for name, load in loads:
        if not load.startswith(("data:", "#")) and str(Path(name).parent / load) not in replays():
            assert not EXTERNAL.match(load), name
            assert (site / name).parent.joinpath(urlparse(load).path).exists(), (name, load)


def test_links_to_elsewhere_are_secure(pages: dict[str, Page]) -> None:
    links = {link for page in pages.values() for link in page.links if EXTERNAL.match(link)}
    assert all(link.startswith("https://") for link in links)


def test_the_rubric_stays_with_the_instructor(site: Path, pages: dict[str, Page]) -> None:
    page = pages["check_your_understanding.html"].text
    quiz = (LESSONS / "quiz.md").read_text("utf-8")
    for heading in re.findall(r"^## (.+)$", quiz, re.MULTILINE):
        assert page.count(heading.split("· ")[1]) >= 1
    rubric = re.findall(r"^\| [12] \| (.+?) \|$", quiz, re.MULTILINE)
    assert len(rubric) == 14
    everything = "".join(page.text for page in pages.values())
    everything += (site / "searchindex.js").read_text("utf-8")
    for answer in rubric:
        assert answer[:40].replace("`", "") not in re.sub("<[^>]+>", "", everything)
    assert not (site / "quiz.html").exists()


def test_licence_stands_on_every_page(pages: dict[str, Page]) -> None:
    for name, page in pages.items():
        if f"{name.removesuffix('.html')}.md" in {p.name for p in PAGES}:
            assert "LICENSE-lessons.md" in page.text, name


def test_the_sentence_that_answers_is_found_whatever_stands_out_in_it() -> None:
    acts = pytest.importorskip("acts", reason="sphinx is not installed: pip install '.[site]'")
    nodes, page = acts.nodes, pytest.importorskip("docutils.utils").new_document("")
    asked, said = nodes.paragraph(), nodes.paragraph()
    asked += acts.Said(quote="*into* the `wall` ahead")
    into, wall = nodes.emphasis(text="into"), nodes.literal(text="wall")
    said += [nodes.Text("It drives "), into, nodes.Text(" the "), wall, nodes.Text("\nahead.")]
    page += [asked, nodes.paragraph(text="It stands."), said]
    acts.LinkWhatIsSaid(page).run()
    assert said["ids"] == ["said-0"]
    assert asked.astext() == '<a href="#said-0">Where it says so</a>'


def test_every_exercise_ends_a_section() -> None:
    linked = re.compile(r"\]\(\.\./exercises/(\w+)/README\.md\)")
    found = []
    for page in PAGES:
        _, *ends = re.split(r"^## Exercises?$", page.read_text("utf-8"), flags=re.MULTILINE)
        found += linked.findall("".join(ends))
    assert sorted(found) == EXERCISES, "link it once, behind `## Exercise` of a page in lessons/"


def test_every_skeleton_is_one_click_away(pages: dict[str, Page]) -> None:
    for slug in EXERCISES:
        page = pages[f"exercises/{slug}/README.html"]
        offered = [page.file.parent / link for link in page.links if "_downloads" in link]
        skeletons = {file.name: file.read_bytes() for file in ROOT.glob(f"exercises/{slug}/*.py")}
        assert {file.name: file.read_bytes() for file in offered} == skeletons
