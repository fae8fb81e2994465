"""The core checks of exercise 6's clients, 40 points: how they ask the grader's own server."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from grader.checks.verdict import fail
from grader.checks.wiring import require_alive, require_wiring
from grader.exercises.model_server.clients import (
    Request,
    detections,
    requests,
    require_heartbeat,
    require_own_topics,
    require_unblocked,
    roles,
    successes,
    warnings,
)
from grader.exercises.model_server.contract import (
    ASK_PERIOD,
    HAIR,
    NEXT_REQUEST,
    PATIENCE,
)
from grader.exercises.model_server.habits import SLOW, is_unblocked
from grader.exercises.model_server.notes import START_UP
from grader.recording import Recording

PUBLISHED_WITHIN = ASK_PERIOD + 0.1  # [s] after the answer; some look for it at their next tick
SLOW_WINDOW = (1.2, 3.2)  # [s] in which the three clients' requests are counted

Recordings = tuple[Recording, ...]


@pytest.mark.check(points=5, scenarios=(SLOW,))
def test_client_wiring(recordings: Recordings) -> None:
    """The client starts, spins, asks /detect and publishes on its topics."""
    for recording in recordings:
        require_wiring(recording, "model_server", "navigation_client")
        if not recording.of("/navigation/heartbeat") and not requests(recording):
            fail(
                "the clients start, and then do nothing at all",
                expected="heartbeats and requests",
                actual="none",
                at=ASK_PERIOD,
                recording=recording,
                help="Does main() spin the node? Does the constructor create the timers, and end?",
            )


@pytest.mark.check(points=10, scenarios=(SLOW, "detect_silent_server"), needs=("client_wiring",))
def test_never_blocks(recordings: Recordings) -> None:
    """A client asks, and goes on whether or not an answer comes: no callback ever blocks."""
    for recording in recordings:
        require_unblocked(recording)


@pytest.mark.check(
    points=10,
    scenarios=("detect_quick_server", SLOW, "detect_restart"),
    needs=("client_wiring",),
)
def test_heartbeat(recordings: Recordings) -> None:
    """A heartbeat every 0.1 s, counting up, without a gap over 0.15 s; with or without a server."""
    _, slow, _ = recordings
    stands = not is_unblocked(slow)  # when it has asked: that is for never_blocks to say
    for recording in recordings:
        first = min((request.at for request in requests(recording)), default=math.inf)
        require_heartbeat(recording, until=first if stands else math.inf)


@pytest.mark.check(
    points=3,
    scenarios=("detect_quick_server", SLOW),
    needs=("client_wiring", "never_blocks"),
)
def test_asks(recordings: Recordings) -> None:
    """Every client asks every 0.5 s, of a server that takes 0.3 s to answer, too."""
    quick, slow = recordings
    require_alive(quick)
    asked = requests(quick)
    if not asked:
        fail(
            "the client never asks",
            expected="a request every 0.5 s",
            at=NEXT_REQUEST,
            recording=quick,
        )
    times = [request.at for request in asked]
    hair = HAIR + quick.slack
    late = times[0] > NEXT_REQUEST + hair or quick.duration_s - times[-1] > ASK_PERIOD + hair
    gaps = [after - before for before, after in pairwise(times)]
    if late or any(abs(gap - ASK_PERIOD) > hair for gap in gaps):
        wrong = next((i for i, gap in enumerate(gaps) if abs(gap - ASK_PERIOD) > hair), -1)
        fail(
            "the client does not ask every 0.5 s",
            expected="a request every 0.5 s of a server that answers at once or after 0.3 s",
            actual=", ".join(f"{time:.2f}" for time in times[max(0, wrong - 4) :][:8]) + " s",
            at=times[wrong],
            recording=quick,
            help="One timer of 0.5 s asks, as long as no answer is owed: the time counts from one "
            "request to the next, not from the answer.",
        )
    require_alive(slow)
    begin, end = SLOW_WINDOW
    count = sum(begin <= request.at < end for request in requests(slow))
    clients = len(roles(slow))
    right = clients * round((end - begin) / ASK_PERIOD)
    if abs(count - right) > clients:
        fail(
            "the clients do not ask every 0.5 s when an answer takes 0.3 s",
            expected=f"{right} ± {clients} requests of {clients} clients in {end - begin:.0f} s",
            actual=f"{count} requests",
            at=begin,
            recording=slow,
            help="The 0.5 s count from one request to the next, not from the answer.",
        )


@pytest.mark.check(
    points=3,
    scenarios=(
        "detect_quick_server",
        SLOW,
        "detect_malformed",
        "detect_default_role",
        "detect_silent_server",
    ),
    needs=("client_wiring", "never_blocks"),
)
def test_publishes(recordings: Recordings) -> None:
    """What the server said is published once, on the topic of the role; nothing if it refused."""
    quick, slow, *nameless, silent = recordings
    for recording in (quick, slow):
        require_alive(recording)
        require_own_topics(recording)
        answers, right = [r for r in requests(recording) if r.success], successes(recording)
        said = detections(recording)
        last = recording.duration_s - PUBLISHED_WITHIN
        for answer in (a for a in answers if a.answered < last):
            count = sum(
                text == answer.message and 0 <= time - answer.answered <= PUBLISHED_WITHIN
                for time, _, text in said
            )
            if count != 1:
                fail(
                    f"the answer of {answer.answered:.2f} s was published {count} times",
                    expected=f"once, on /ROLE/detection: {answer.message}",
                    actual=_spoken_after(said, answer.answered),
                    at=answer.answered,
                    recording=recording,
                    help="When the future is done: String(data=response.message), if success.",
                )
        for time, role, text in said:
            if text not in right:
                fail(
                    f"/{role}/detection carried something that is no detection",
                    expected="only messages of answers with success = true, as they are",
                    actual=text[:200],
                    at=time,
                    recording=recording,
                    help="Look at response.success first, and don't touch response.message.",
                )
        if not any(answer.answered < last for answer in answers):
            fail(
                "the server had no request to answer",
                expected="requests of /detect",
                at=NEXT_REQUEST,
                recording=recording,
            )
    for recording in nameless:
        _require_role(recording)
    _require_no_repeats(silent)


def _require_role(recording: Recording) -> None:
    """Fail unless a client that has a role, and no name but its own, speaks on its topics."""
    (role,) = roles(recording)
    good = [r for r in requests(recording) if r.success]
    if good and not detections(recording):
        own = [e.topic for e in recording.endpoints if e.topic.endswith("/detection")]
        fail(
            f"a client started {_options(recording)} publishes no detection",
            expected=f"what the server said, on /{role}/detection",
            actual=f"publishers on {', '.join(sorted(set(own)))}" if own else "no such publisher",
            at=good[0].answered,
            recording=recording,
            help="The role is the parameter, whatever the node is called: "
            "self.declare_parameter('role', 'navigation').value",
        )


def _options(recording: Recording) -> str:
    """Return in words what the client was told when it started."""
    options = [a for p in recording.scenario.program if not p.supplied for a in p.arguments]
    told = [option for option in options if option.startswith("role:=")]
    return f"with -p {told[0]}, and no other name," if told else "without parameters"


def _require_no_repeats(recording: Recording) -> None:
    """Fail if an answer is published twice, however late the next one comes."""
    seen: set[str] = set()
    for time, role, text in detections(recording):
        if text in seen:
            fail(
                f"/{role}/detection carried the same answer again",
                expected="each answer once; nothing while no answer comes",
                actual=text[:200],
                at=time,
                recording=recording,
                help="Publish in the callback of the answer, and nowhere else.",
            )
        seen.add(text)


@pytest.mark.check(
    points=3,
    scenarios=("detect_silent_server", "detect_restart"),
    needs=("client_wiring", "never_blocks"),
)
def test_gives_up(recordings: Recordings) -> None:
    """One request at a time; without an answer it is given up after 1 s, with a warning."""
    silent, restart = recordings
    require_alive(silent)
    found = requests(silent)
    if all(math.isfinite(request.answered) for request in found):
        fail(
            "the client asked too rarely to be left without an answer",
            expected="requests until the end of the scenario",
            actual=f"{len(found)}, and each was answered",
            at=found[-1].at if found else NEXT_REQUEST,
            recording=silent,
            help="A timer of 0.5 s asks, unless a request is open.",
        )
    followed = [*found[1:], None]
    for request, after in zip(found, followed, strict=True):
        _require_patience(silent, request, after)
        _require_warning(silent, request, begin=request.at + PATIENCE - HAIR - silent.slack)
    for request in requests(restart):  # a client may see that its server has gone, and say so
        _require_warning(restart, request, begin=request.at)


@pytest.mark.check(points=3, scenarios=("detect_restart",), needs=("client_wiring", "never_blocks"))
def test_finds_server(recordings: Recordings) -> None:
    """It starts before the server, outlives it, and finds it again."""
    for recording in recordings:
        require_alive(recording)
        times = [request.at for request in requests(recording)]
        lives = [p for p in recording.scenario.program if p.supplied]
        for number, life in enumerate(lives):
            end = life.stop or recording.duration_s
            first = min((time for time in times if life.start <= time <= end), default=None)
            latest = NEXT_REQUEST + HAIR + recording.slack
            if recording.live is not None:  # in real time a server takes time to start
                latest += START_UP
                if first is None and end - life.start < latest:
                    continue
            if first is None or first - life.start > latest:
                fail(
                    "the client does not find the server again"
                    if number
                    else "the client does not find a server that starts after it",
                    expected=f"a request within {NEXT_REQUEST} s of {life.start:.2f} s, when the "
                    f"server {'is back' if number else 'starts'}",
                    actual="none" if first is None else f"the first at {first:.2f} s",
                    at=life.start,
                    recording=recording,
                    help="Look for the server at every tick, not once; and give up a request that "
                    "the old server took with it.",
                )


@pytest.mark.check(
    points=3, scenarios=("detect_malformed",), needs=("client_wiring", "never_blocks", "publishes")
)
def test_malformed(recordings: Recordings) -> None:
    """Malformed answers are dropped or published, and the client goes on."""
    for recording in recordings:
        require_alive(recording)
        found = requests(recording)
        kinds = [_kind(recording, request.number) for request in found]
        said = {text for _, _, text in detections(recording)}
        last = recording.duration_s - PUBLISHED_WITHIN
        for request, kind in zip(found, kinds, strict=True):
            before = _kind(recording, request.number - 1) if request.number > 0 else "none"
            if kind == "fine" and request.answered < last and request.message not in said:
                fail(
                    f"a good answer after one of the kind “{before}” is not published",
                    expected=request.message,
                    actual=f"nothing of the kind on /{roles(recording)[0]}/detection",
                    at=request.answered,
                    recording=recording,
                    help="Whatever a callback raises on a bad answer, the next one is a new start.",
                )
        end, before = (found[-1].at, kinds[-1]) if found else (0.0, "none")
        if recording.duration_s - end > NEXT_REQUEST + HAIR:
            fail(
                f"after an answer of the kind “{before}” the client stops asking",
                expected="requests until the end of the scenario",
                actual=f"the last at {end:.2f} s",
                at=end,
                recording=recording,
                help="Forget the request before you look at its answer.",
            )


def _require_patience(recording: Recording, request: Request, after: Request | None) -> None:
    """Fail unless the next request waits until this one is answered or, in time, given up."""
    hair = HAIR + recording.slack
    wait = (after.at if after else recording.duration_s) - request.at
    owed = request.answered - request.at > wait  # when the next request goes out
    if after and owed and wait < PATIENCE - hair:
        fail(
            f"{wait:.2f} s after a request the next went out, though no answer had come",
            expected=f"at most one request at a time; it is given up after {PATIENCE} s",
            actual=f"requests at {request.at:.2f} s and {after.at:.2f} s",
            at=after.at,
            recording=recording,
            help="Remember the future; while it is there and not done, don't ask again. What comes "
            "late is the answer to another request.",
        )
    if request.answered - request.at > PATIENCE and wait > NEXT_REQUEST + hair:
        fail(
            "a request without an answer is not given up",
            expected=f"the next request {PATIENCE} to {NEXT_REQUEST} s after {request.at:.2f} s",
            actual=f"{wait:.2f} s after it" if after else "no further request",
            at=request.at + NEXT_REQUEST,
            recording=recording,
            help="Remember when you asked; at each tick, compare. remove_pending_request() forgets "
            "the old request.",
        )


def _require_warning(recording: Recording, request: Request, begin: float) -> None:
    """Fail if a request that was never answered was given up without a warning from `begin` [s]."""
    end = request.at + NEXT_REQUEST + HAIR + recording.slack
    due = end < recording.duration_s
    if math.isinf(request.answered) and due and not warnings(recording, begin, end):
        fail(
            "a request was given up without a warning",
            expected=f"a warning in the log between {begin:.2f} s and {end:.2f} s",
            actual="none",
            at=end,
            recording=recording,
            help="self.get_logger().warning(…)",
        )


def _kind(recording: Recording, number: int) -> str:
    """Return the kind of the grader's server's answer to a request."""
    words = [word for program in recording.scenario.program for word in program.arguments]
    plan = next(word for word in words if word.startswith("answers:="))
    kinds = [word.partition("@")[0] for word in plan.removeprefix("answers:=").split()]
    return kinds[max(0, min(number, len(kinds) - 1))]  # the last word repeats


def _spoken_after(said: list[tuple[float, str, str]], begin: float) -> str:
    spoken = [
        f"{time:.2f} s: {text[:80]}"
        for time, _, text in said
        if 0 <= time - begin <= PUBLISHED_WITHIN
    ]
    return "; ".join(spoken[:3]) or "nothing on /ROLE/detection"
