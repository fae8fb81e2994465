import base64
import hashlib
import json
import math
import re
from typing import Any

import numpy as np
import pytest

from grader.report.page import PLAYER, json_text, page_html

HOSTILE = "</script><script>alert(1)</script><!--<script> \u2028\u2029 & @@CSP@@ \U0001f916 \ud800"


def payload(**parts: Any) -> dict[str, Any]:
    return {"grading": None, "replays": [], "title": "A run", "generated_by": "test", **parts}


def embedded(page: str) -> Any:
    found = re.search(r'<script type="application/json" id="payload">(.*?)</script>', page, re.S)
    assert found
    return json.loads(found[1])


def test_the_payload_comes_back_whole_but_for_what_is_not_seen() -> None:
    page = page_html(payload(title=HOSTILE, replays=[{"title": HOSTILE}]))
    seen = HOSTILE.replace("\u2028\u2029", "")
    assert embedded(page)["title"] == seen
    assert embedded(page)["replays"] == [{"title": seen}]


def test_hostile_text_adds_no_element() -> None:
    calm, hostile = page_html(payload()), page_html(payload(title=HOSTILE, generated_by=HOSTILE))
    for tag in ("<script", "</script", "<!--", "<title"):
        assert hostile.count(tag) == calm.count(tag)
    assert "\u2028" not in hostile
    hostile.encode("utf-8")


def test_the_policy_names_exactly_the_inline_script_and_style() -> None:
    page = page_html(payload())
    found = re.search(r'Content-Security-Policy" content="([^"]*)"', page)
    assert found
    policy = dict(part.split(" ", 1) for part in found[1].split("; "))
    assert policy["default-src"] == "'none'"
    for directive, element in (("script-src", "script"), ("style-src", "style")):
        inline = re.findall(rf"<{element}>(.*?)</{element}>", page, re.S)
        assert len(inline) == 1
        digest = hashlib.sha256(inline[0].encode()).digest()
        assert policy[directive] == f"'sha256-{base64.b64encode(digest).decode()}'"


def test_the_page_refers_to_nothing_outside() -> None:
    page = page_html(payload())
    addresses = set(re.findall(r"https?://[^\s'\"]+", page))
    assert addresses <= {"http://www.w3.org/2000/svg"}
    assert "@import" not in page
    assert "url(" not in page


def test_the_player_never_parses_text_as_html() -> None:
    for script in PLAYER.glob("*.js"):
        source = script.read_text(encoding="utf-8")
        for danger in ("innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval("):
            assert danger not in source, script.name
        assert "</script" not in source


@pytest.mark.parametrize(
    ("grading", "read"),
    [
        ({"t": (math.nan, math.inf, -math.inf, np.float32("nan"))}, {"t": [None] * 4}),
        ({"points": np.int64(3), "score": np.float64(1.5)}, {"points": 3, "score": 1.5}),
        ({"t": np.array([1.0, math.nan]), 3: True}, {"t": [1.0, None], "3": True}),
        ({"file": PLAYER, "d": (1, 2)}, {"file": str(PLAYER), "d": [1, 2]}),
    ],
)
def test_json_knows_numbers_arrays_and_paths(grading: dict[Any, Any], read: Any) -> None:
    assert json.loads(json_text(grading)) == read
    assert embedded(page_html(payload(x=grading)))["x"] == read


def test_json_has_one_order_of_keys() -> None:
    assert json_text({"b": 1, "a": {"d": 2, "c": None}}) == json_text(
        {"a": {"c": None, "d": 2}, "b": 1}
    )
