"""Hostile submissions gain nothing, honest ones lose nothing; both are graded for real.

`make test` takes one hostile submission of each family and five honest ones, `make test-long` the
others, in the scenario in which points are cheapest; `COURSE_ATTACKS=full` (`make attacks`) runs
every check.
"""

import io
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest
from arena import EXERCISE, FULL, HONEST, HOSTILE, REFERENCE, SOME, Arena, Trick, children, orphans
from rich.console import Console

from grader.grading.grading import grade_submission
from grader.grading.plugin import UNJUDGED
from grader.report.page import page_html, page_payload
from grader.report.terminal import render_terminal
from grader.trial.virtual_time import run_trial
from rclpy_virtual_time.link.hosts import ForkServer
from sim.scenario_files import load_scenario

NEXT = load_scenario("avoid_zones")
BENCHES = ("clear_zone", "stop_zone", "infinite_readings", "blind")
FAMILIES = ("escape", "exhaust", "feedback", "forge", "read", "topics")
QUICK = (  # in `make test`
    *("escape_calls_by_number", "exhaust_disk", "feedback_html", "forge_completed"),
    *("read_solutions", "topics_ground_truth"),
)
QUICK_HONEST = ("latin_1", "odd_classes")
FEEDBACK = [trick for trick in HOSTILE if trick.path.stem == "feedback"]


@pytest.fixture(scope="module")
def arena(forkserver: ForkServer) -> Iterator[Arena]:
    with Arena(forkserver.layers) as arena:
        yield arena


@pytest.fixture(scope="module")
def digest(forkserver: ForkServer) -> str:
    """What the reference does when nobody has attacked yet."""
    return run_trial(REFERENCE, NEXT, forkserver).digest()


@pytest.fixture(scope="module")
def honest_points(arena: Arena, forkserver: ForkServer) -> int:
    """What the honest part of the hostile submissions is worth."""
    path = arena.played / "constant.py"
    path.write_text("from kit import drive\n\ndrive()\n")
    return arena.grade(path, forkserver, hasty=False, everything=FULL).score


def named(one: Path | Trick) -> str:
    return one.name if isinstance(one, Trick) else one.stem


def sparing(every: Iterable[Path | Trick], quick: tuple[str, ...]) -> list[Any]:
    """Return all as parameters; `make test` takes the quick ones."""
    marks = {True: (), False: pytest.mark.long}
    return [pytest.param(e, id=named(e), marks=marks[named(e) in quick]) for e in every]


def test_make_test_tries_every_family() -> None:
    assert {trick.path.stem for trick in HOSTILE} == set(FAMILIES)
    assert set(QUICK) <= {trick.name for trick in HOSTILE}
    assert [name.partition("_")[0] for name in QUICK] == list(FAMILIES)
    assert set(QUICK_HONEST) <= {path.stem for path in HONEST}


@pytest.mark.parametrize("trick", sparing(HOSTILE, QUICK))
def test_a_hostile_submission_gains_nothing(
    trick: Trick, arena: Arena, forkserver: ForkServer, digest: str, honest_points: int
) -> None:
    if trick.full and not FULL:
        pytest.skip("shows only with all checks: make attacks")
    before = orphans()
    hasty = trick.hangs and (not FULL or trick.name != "exhaust_sleep_for_ever")
    grading = arena.grade(arena.tricked(trick), forkserver, hasty=hasty, everything=FULL)

    assert arena.said(grading.recordings) == []
    assert arena.losses() == []
    assert orphans() <= before
    assert children(forkserver._process.pid) == []
    assert grading.score <= max(trick.score if FULL else 0, honest_points)
    unjudged = [check for check in grading.checks if check.outcome in UNJUDGED]
    assert not [check for check in unjudged if check.outcome == "error"]
    assert grading.faulty == bool(unjudged), "points are out of reach, and nobody is told"
    if "any" not in trick.outcomes:
        assert {recording.outcome.kind for recording in grading.recordings} <= trick.outcomes
    assert run_trial(REFERENCE, NEXT, forkserver).digest() == digest


@pytest.mark.parametrize("path", sparing(HONEST, QUICK_HONEST))
def test_an_odd_but_honest_submission_loses_nothing(
    path: Path, arena: Arena, forkserver: ForkServer
) -> None:
    only = () if FULL else BENCHES
    grading = grade_submission(
        EXERCISE, arena.submission(path), forkserver, file=path.name, only=only
    )

    assert [(c.id, c.message) for c in grading.checks if c.outcome != "pass"] == []
    assert arena.said(grading.recordings) == []
    assert arena.losses() == []
    if FULL:
        assert (grading.score, grading.max_score) == (100, 100)


def test_after_all_attacks_the_reference_has_full_marks(
    forkserver: ForkServer, digest: str
) -> None:
    only = () if FULL else BENCHES
    grading = grade_submission(EXERCISE, REFERENCE, forkserver, file="reference.py", only=only)

    assert 0 < grading.score == grading.max_score and not grading.faulty
    assert digest in [recording.digest() for recording in grading.recordings]


@pytest.mark.parametrize("trick", FEEDBACK, ids=named)
def test_feedback_is_text_and_nothing_else(
    trick: Trick, arena: Arena, forkserver: ForkServer
) -> None:
    """What a submission says is shown, but it can't become part of a page or steer a terminal."""
    path = arena.tricked(trick)
    submission = arena.submission(path)
    grading = grade_submission(EXERCISE, submission, forkserver, file=path.name, only=SOME)
    result = grading.as_dict()
    page = page_html(page_payload(result, grading.recordings, path.name))
    screen = io.StringIO()
    render_terminal(result, Console(file=screen, width=120, force_terminal=False))

    assert "<script>document.title" not in page
    assert "<img src=x" not in page
    assert page.count("</script>") == page_html(page_payload(None, [], "")).count("</script>")
    assert not set(screen.getvalue()) & {"\x1b", "\x07", "\x9b", "\u202e", "\r"}
    assert len(page) < 4_000_000
