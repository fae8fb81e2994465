"""What no closing speed at all, or none but 0, is taken for."""

from types import SimpleNamespace
from typing import Any

import pytest

from grader.exercises.trend_memory import causes

ALWAYS_0 = [(float(i), SimpleNamespace(data=0.0)) for i in range(6)]
ONE_RIGHT = [*ALWAYS_0, (9.0, SimpleNamespace(data=0.3))]


@pytest.mark.parametrize(
    ("closing_speeds", "failed", "said"),
    [
        ([], ["closing_speed"], "not one message comes on /closing_speed"),
        (ALWAYS_0, ["closing_speed"], "all 6 closing speeds are exactly 0"),
        (ONE_RIGHT, ["closing_speed"], ""),
        (ALWAYS_0[:2], ["closing_speed"], ""),
        ([], ["drives_free"], ""),
    ],
)
def test_the_memory_is_asked_for_where_nothing_comes_of_it(
    closing_speeds: Any, failed: list[str], said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(causes, "published", lambda *_: closing_speeds)
    run: Any = SimpleNamespace(outcome=SimpleNamespace(completed=True), scans=lambda: [None] * 30)

    found = causes.seen({"trend": run}, failed)

    assert (found.text if found else "").startswith(said)
    assert bool(found) == bool(said)
    assert found is None or list(found.explains) == failed
