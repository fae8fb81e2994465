"""axe-core finds nothing to complain about in a replay and in a report, light or dark."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import payloads
import pytest

pytestmark = pytest.mark.long


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("embedded", [False, True], ids=["report", "replay"])
def test_page_has_no_violations(
    open_page: Callable[..., Any], axe: Any, scheme: str, embedded: bool
) -> None:
    payload = payloads.failing_page()
    if embedded:  # as in the lesson's pages and in notebooks
        payload |= {"grading": None, "embedded": True, "title": "one_beam_agent.py in demo_wall"}
    page = open_page(payload, color_scheme=scheme, bypass_csp=True)
    assert axe(page) == []
    assert page.locator("h1").count() == 1


def test_a_replay_in_a_page_is_printed_without_its_controls(open_page: Callable[..., Any]) -> None:
    payload = payloads.failing_page() | {"grading": None, "embedded": True}
    page = open_page(payload)
    page.emulate_media(media="print")
    assert page.locator("canvas.map").is_visible()
    assert not page.locator(".transport").is_visible()
