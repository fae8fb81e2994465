"""What checks forgive a busy machine in real time; in virtual time they forgive nothing."""

import contextlib
import json
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.recording import Compute, Inference, Recording

CHECK = "check(points, scenarios): named here because checks are imported outside of a grading"
EPOCH = 1_700_000_000_000_000_000  # [ns]
LIVE = object()
SCANS = tuple(SimpleNamespace(t=i / 2, stamp=i / 2) for i in range(4))  # at 0, 0.5, 1 and 1.5 s


@pytest.fixture(autouse=True)
def _marker(pytestconfig: pytest.Config) -> None:
    pytestconfig.addinivalue_line("markers", CHECK)


def recording(live: object = LIVE, slack: float = 0.0, **others: Any) -> Any:
    return SimpleNamespace(
        live=live, slack=slack, epoch=EPOCH, scans=lambda: SCANS, duration_s=2.0, **others
    )


# --- what the machine took ------------------------------------------------------------------------


def measured(live: bool) -> Any:
    """Five turns of 0.1 s; a thread waited 40 ms in the one at 0.2 s, and 30 ms in the next."""
    none, turns = np.zeros(5), np.arange(5) / 10
    compute = Compute(turns, none, none, np.array([0.0, 0.0, 0.04, 0.03, 0.0]))
    return SimpleNamespace(live=SimpleNamespace(lateness=0.01) if live else None, compute=compute)


def with_methods(fake: Any) -> Any:
    fake.delay = lambda begin, end: Recording.delay(fake, begin, end)
    fake.waited = lambda begin, end: Recording.waited(fake, begin, end)
    return fake


@pytest.mark.parametrize(
    ("begin", "end", "delay"),
    [
        (0.2, 0.28, 0.05),
        (0.25, 0.28, 0.05),
        (0.2, 0.35, 0.05),
        (0.3, 0.4, 0.04),
        (0.0, 0.15, 0.01),
        (0.45, 9.0, 0.01),
    ],
)
def test_a_delay_is_what_was_measured_meanwhile(begin: float, end: float, delay: float) -> None:
    for live in (True, False):
        fake = with_methods(measured(live))
        assert fake.delay(begin, end) == pytest.approx(delay if live else 0.0)
        assert fake.waited(begin, end) == pytest.approx(delay - 0.01 if live else 0.0)


@pytest.mark.parametrize(
    ("live", "command", "prompt"),
    [(True, 0.29, True), (True, 0.34, False), (True, 0.19, False), (False, 0.26, False)],
)
def test_a_scan_waits_for_its_command_no_longer_than_the_machine_made_it(
    live: bool, command: float, prompt: bool
) -> None:
    from grader.checks.model_commands import require_prompt  # noqa: PLC0415
    from grader.checks.verdict import CheckFailed  # noqa: PLC0415

    fake = measured(live)
    fake.name, fake.twists = "prompt", lambda: SimpleNamespace(t=np.array([command]))
    with_methods(fake)
    with contextlib.nullcontext() if prompt else pytest.raises(CheckFailed, match="had to wait"):
        require_prompt(fake, 0.2)


# --- exercise 6: scans and requests that cross ----------------------------------------------------


def told(stamp: float | None, success: bool = True) -> Any:
    message = json.dumps({} if stamp is None else {"stamp": EPOCH / 1e9 + stamp})
    return SimpleNamespace(success=success, message=message)


@pytest.mark.parametrize(
    ("at", "answer", "newest"),
    [
        (1.25, told(1.0), 2),
        (1.03, told(0.5), 1),  # the scan of 1.0 s was still on its way
        (0.97, told(1.0), 2),  # the request was
        (1.25, told(0.5), 2),  # too long ago: that answer is wrong
        (0.75, told(1.0), 1),  # from the future: wrong too
        (1.03, told(0.0), 2),  # neither of the two
        (0.03, told(None, success=False), -1),  # rightly refused: it had none yet
        (1.03, told(None), 2),  # no stamp at all
        (1.25, None, 2),  # no answer at all
    ],
)
def test_the_scan_that_a_server_had_is_one_that_it_can_have_had(
    monkeypatch: pytest.MonkeyPatch, at: float, answer: Any, newest: int
) -> None:
    from grader.exercises.model_server import answers  # noqa: PLC0415

    def allowed(scan: Any, asked: float) -> Any:
        return SimpleNamespace(refusal=scan is None)

    monkeypatch.setattr(answers, "allowed", allowed)
    assert answers._newest(recording(), at, answer) == newest


def test_in_virtual_time_the_newest_scan_is_the_newest() -> None:
    from grader.exercises.model_server.answers import _newest  # noqa: PLC0415

    assert _newest(recording(None), 1.0, told(0.5)) == 2


@pytest.mark.parametrize(
    ("live", "at", "just"),
    [(LIVE, 1.2, True), (LIVE, 2.1, False), (LIVE, 0.9, False), (None, 1.2, False)],
)
def test_who_is_asked_while_its_program_starts_is_not_judged(
    live: object, at: float, just: bool
) -> None:
    from grader.exercises.model_server.answers import _just_started  # noqa: PLC0415

    programs = [
        SimpleNamespace(start=0.0, supplied=False),
        SimpleNamespace(start=1.0, supplied=False),
        SimpleNamespace(start=1.9, supplied=True),  # ours
    ]
    scenario = SimpleNamespace(program=programs)
    assert _just_started(recording(live, scenario=scenario), at) is just


def test_a_request_from_before_the_beginning_is_none_but_its_answer_is_known(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from grader.checks.verdict import CheckFailed  # noqa: PLC0415
    from grader.exercises.model_server import clients  # noqa: PLC0415
    from grader.exercises.model_server.notes import Answered, Asked  # noqa: PLC0415

    noted = [
        (0.1, Answered(0, success=True, message="early", life=7)),  # nobody noted that it was asked
        (0.2, Asked(1, life=7)),
        (0.3, Asked(0, life=9)),  # another server, which counts anew
        (0.4, Answered(0, success=True, message="new", life=9)),
        (0.5, Answered(1, success=False, message="late", life=7)),
    ]
    monkeypatch.setattr(clients, "notes", lambda *_: noted)
    assert clients.requests(recording()) == [
        clients.Request(1, 0.2, 0.5, success=False, message="late"),
        clients.Request(0, 0.3, 0.4, success=True, message="new"),
    ]
    assert clients.successes(recording()) == {"early", "new"}
    with pytest.raises(CheckFailed, match="a topic of the grader's"):
        clients.requests(recording(None, name="virtual", endpoints=()))


# --- exercise 9: calls that take a little longer --------------------------------------------------


def profiled(live: object, slack: float = 0.0) -> Any:
    """A hundred calls of 30 ms, one for each scan at 40 Hz: they wait for one another."""
    calls = [
        Inference("predict", "model.pkl", i * 30_000_000, (i + 1) * 30_000_000, 30_000_000, (0.1,))
        for i in range(100)
    ]

    class Profiled(SimpleNamespace):
        __hash__ = object.__hash__

    scenario = SimpleNamespace(node=SimpleNamespace(parameters={}))
    return Profiled(live=live, slack=slack, scenario=scenario, inferences=calls)


def counts(recording: Any, time: float) -> set[float]:
    from grader.exercises.latency_monitor.contract import right_statistics  # noqa: PLC0415

    return {choice.numbers["count"] for choice in right_statistics(recording, time)}


def test_a_call_that_ends_near_a_report_may_count_or_not() -> None:
    assert counts(profiled(None), 2.0) == {66}  # 2.0 s / 30 ms
    assert counts(profiled(LIVE), 1.982) == {65, 66}  # 66 ended at 1.980 s, or a moment later
    assert counts(profiled(LIVE, slack=0.04), 2.0) == {65, 66, 67, 68}
    assert counts(profiled(LIVE), 0.0) == {0}


@pytest.mark.parametrize(
    ("live", "mean", "right"),
    [(None, 30.0, True), (None, 31.0, False), (LIVE, 33.9, True), (LIVE, 34.2, False)],
)
def test_a_call_takes_up_to_four_milliseconds_longer_in_real_time(
    live: object, mean: float, right: bool
) -> None:
    from grader.exercises.latency_monitor.contract import right_statistics  # noqa: PLC0415

    choices = right_statistics(profiled(live), 2.0)
    assert any(choice.allows("mean_ms", mean) for choice in choices) is right


def test_levels_between_the_least_and_the_most_are_right() -> None:
    from grader.exercises.latency_monitor.contract import (  # noqa: PLC0415
        ERROR,
        OK,
        STALE,
        WARN,
        Statistics,
    )

    assert Statistics((99.0,) * 100, 100.0).levels == {OK}
    assert Statistics((99.0,) * 100, 100.0, late=2.0).levels == {OK, WARN, ERROR}
    assert Statistics((), 100.0, late=2.0).levels == {STALE}


# --- exercises 1, 2 and 8: answers after the end --------------------------------------------------


def bench(monkeypatch: pytest.MonkeyPatch, answered: int, sent: int = 4) -> Any:
    from grader.checks import commands  # noqa: PLC0415

    tags = ((), ("a",), ("a",), ("b",))
    scenario = SimpleNamespace(
        bench_scans=[SimpleNamespace(tags=each) for each in tags],
        faults=SimpleNamespace(scan_loss=0.0),
        name="bench",
    )
    found = [SimpleNamespace(tags=each) for each in tags[:answered]]
    monkeypatch.setattr(commands, "answers", lambda _: found)
    monkeypatch.setattr(commands, "require_alive", lambda _: None)
    result = recording(scenario=scenario, name="bench")
    result.scans = lambda: SCANS[:sent]
    return result


def test_scans_whose_answer_would_come_after_the_end_are_left_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from grader.checks.commands import judged  # noqa: PLC0415
    from grader.checks.verdict import CheckFailed  # noqa: PLC0415

    assert len(judged(bench(monkeypatch, answered=4), "a")) == 2
    assert len(judged(bench(monkeypatch, answered=2), "a")) == 1
    assert len(judged(bench(monkeypatch, answered=3))) == 3
    with pytest.raises(CheckFailed, match="no command came for the scans “b”"):
        judged(bench(monkeypatch, answered=3), "b")
    with pytest.raises(CheckFailed, match="ended before all of its scans were sent"):
        judged(bench(monkeypatch, answered=3, sent=3), "a")
