"""What the pages promise a reader: so many minutes, and questions that have to be read."""

import math
import re
from collections import Counter

import numpy as np
import pytest
from contract import read
from lesson_pages import PAGES, QUESTION
from reading_time import ACTS, CODE, WORDS, minutes, unfolded

SOURCES = {page.stem: page.read_text("utf-8") for page in PAGES}
PROMISED = re.compile(r"(?m)^\*(\d+) minutes?(?:, (\d+) with all that is folded)?\b")
WAYS = [
    way
    for way in re.split(r"(?m)^## ", SOURCES["index"])
    if re.match(r"The .*lesson,? in \d+ minutes", way)
]
ROWS = re.compile(r"(?m)^\| \[[^|]+\]\((\w+)\.md\) \| (\d+) \|(?: (\d+) \|$)?")
ROUNDING = 1.0  # [min]


@pytest.mark.parametrize("page", [name for name in SOURCES if PROMISED.search(SOURCES[name])])
def test_a_page_takes_the_minutes_that_it_says(page: str) -> None:
    source = SOURCES[page]
    found = PROMISED.findall(source)
    seen, whole = found[0]
    assert len(found) == 1
    assert minutes(unfolded(source)) == pytest.approx(int(seen), abs=ROUNDING)
    assert minutes(source) == pytest.approx(int(whole or seen), abs=ROUNDING)


def test_the_ways_of_the_front_page_add_up_and_their_pages_say_the_same() -> None:
    lessons = re.findall(r"(?m)^:caption: (The .*lesson)$", SOURCES["index"])  # of the toctrees
    assert lessons and lessons == [re.findall(r"The .*?lesson", way)[0] for way in WAYS]
    for way in WAYS:
        rows = ROWS.findall(way)
        total = sum(int(seen) for _, seen, _ in rows)
        assert total == int(re.findall(r"\d+", way)[0])
        for page, seen, whole in rows:
            assert PROMISED.findall(SOURCES[page])[0][0] == seen, page
            folded = "*Deeper*" in way and int(whole) > int(seen)
            assert PROMISED.findall(SOURCES[page])[0][1] == (whole if folded else ""), page
        if "*Deeper*" in way:
            whole = sum(int(row[2]) for row in rows)
            assert f"| **All of it** | **{total}** | **{whole}** |" in way


def test_the_front_page_says_how_the_minutes_are_counted() -> None:
    said = " ".join(SOURCES["index"].split())
    seconds = [f"{60 * ACTS[act]:.0f}" for act in ("{question}", "{watch}", "{figure}")]
    assert f"{WORDS} words, {CODE['python']} lines of a program or {CODE['output']} lines" in said
    assert (
        "{} seconds for a question or a figure to play with, {} for a replay, {} for".format(
            *seconds
        )
        in said
    )
    assert ACTS["{play}"] == ACTS["{question}"]


def test_a_short_page_is_not_promised_as_a_long_one() -> None:
    code = "```python\n" + "x = 1\n\n" * 30 + "```\n"
    folded = f"<details><summary>More</summary>\n\n{code}<details>\n{code}</details></details>\n"
    assert minutes("word " * 300 + folded) == pytest.approx(6.0, abs=0.1)
    assert minutes(unfolded("word " * 300 + folded)) == pytest.approx(2.0)
    asked = ":::{question} Why?\n\n- [x] So\n\n  Because.\n:::\n"
    assert minutes(asked) == pytest.approx(0.75)


def test_who_guesses_finds_the_answer_without_a_replay() -> None:
    watched = re.compile(r"(?ms)^```\{watch\} (.*?)^```\n\n(.*?)$")
    follows = [
        after
        for source in SOURCES.values()
        for caption, after in watched.findall(source)
        if "**Guess first:**" in caption
    ]
    assert len(follows) >= 8
    for after in follows:
        assert after.startswith(("```console", '<details class="look">')), after


ASKED = {
    name: [block["body"] for block in QUESTION.finditer(source)] for name, source in SOURCES.items()
}
RIGHT = re.compile(r"(?m)^- \[x\] (.+)$")


def test_the_place_of_an_option_does_not_give_it_away() -> None:
    marks = [re.findall(r"(?m)^- \[([ x])\] ", body) for all_ in ASKED.values() for body in all_]
    places = Counter(options.index("x") for options in marks)
    assert all(len(options) >= 3 for options in marks)
    assert max(places.values()) <= len(marks) / 2, places


NUMBER = re.compile(r"(?<![\w.-])\d+(?:\.\d+)?(?![\w-])")
WORKED_OUT = {"awaiting": "3.5 6.0 8.5", "why": "288"}  # by an answer itself


def test_what_an_answer_quotes_stands_on_its_page() -> None:
    """And in a table, if it says so."""
    contract = " ".join(each.text for each in read().values())
    lost = []
    for name, source in SOURCES.items():
        rest = QUESTION.sub("", source)
        rows = " ".join(re.findall(r"(?m)^\|.*", rest))
        for body in ASKED[name]:
            asked = re.sub(r"(?m)^  .*", "", body)
            page = " ".join([rest, asked, contract, WORKED_OUT.get(name, "")])
            for why in re.findall(r"(?m)^  .*(?:\n  .*)*", body):
                there = NUMBER.findall(rows if "in the table" in why else page)
                lost += [f"{name}: {each}" for each in NUMBER.findall(why) if each not in there]
    assert lost == []


def number(key: str) -> float:
    return read()[key].value


def late_stop(speed: float, late: float) -> float:
    """Return what the course's robot still drives [m]."""
    return speed * late + speed**2 / (2 * number("robot_acceleration"))


@pytest.mark.parametrize(
    ("page", "answer", "computed"),
    [
        ("why", "Every 100 seconds", 1 / (0.001 * number("lidar_rate"))),
        ("loop", "0.25 and 0.4 m/s", float(np.interp(1.8, [0.6, 1.2, 2.4], [0.0, 0.1, 0.4]))),
        ("loop", "11 cm", 100 * late_stop(0.3, 0.2)),
        ("models", "Next to nothing: it is 0.01 m/s better than the median", 0.07 - 0.06),
        ("state", "110°, to the right", -math.degrees(math.remainder(math.radians(250), math.tau))),
    ],
)
def test_what_a_question_calls_right_is_so(page: str, answer: str, computed: float) -> None:
    right = [RIGHT.findall(body)[0] for body in ASKED[page]]
    assert answer in right
    found = re.findall(r"-?\d+(?:\.\d+)?", answer)
    assert float(found[0]) == pytest.approx(computed)
