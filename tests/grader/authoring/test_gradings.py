"""Claims are graded by several processes that are replaced after a while, and in their order."""

import pytest

from grader.authoring import gradings
from grader.claims.claims import claims
from grader.course.exercises import find_exercise


@pytest.mark.long
def test_processes_are_replaced_and_the_order_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gradings, "PER_PROCESS", 2)
    known = {claim.stem: claim for claim in claims(find_exercise("obstacle_avoidance"))}
    chosen = [known[name] for name in ("dies_in_the_constructor", "wrong_topic") * 4]
    found = [grading.file for grading in gradings.gradings(chosen, workers=2)]
    assert found == [f"{claim.stem}.py" for claim in chosen], found
