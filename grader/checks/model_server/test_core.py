"""The core checks of exercise 6; they sum to 100 points.

The server is judged by what it tells the grader's own client, the clients by what they ask the
grader's own server: half of the exercise can be right without the other.
"""

from __future__ import annotations

import re
from itertools import pairwise

import pytest

from grader.checks.model_server.answers import (
    asks,
    require_contract,
    require_detection,
    require_refusal,
    require_success,
)
from grader.checks.model_server.clients import (
    Request,
    detections,
    requests,
    require_heartbeat,
    require_unblocked,
    roles,
    warnings,
)
from grader.checks.model_server.contract import (
    ASK_PERIOD,
    HAIR,
    NEXT_REQUEST,
    PATIENCE,
    ROLES,
    allowed,
)
from grader.checks.wiring import require_alive, require_wiring
from grader.recording import Recording
from grader.verdict import fail

PUBLISHED_WITHIN = ASK_PERIOD + 0.1  # [s] after the answer; some look for it at their next tick
SLOW_WINDOW = (1.2, 3.2)  # [s] in which the three clients' requests are counted

Recordings = tuple[Recording, ...]

# --- the server: 55 points -----------------------------------------------------------------------


@pytest.mark.check(points=5, scenarios=("detect_answers",))
def test_server_wiring(recordings: Recordings) -> None:
    """The server starts, spins, listens to /scan and offers the service /detect."""
    for recording in recordings:
        require_wiring(recording, "model_server", "detection_server")
        if not any(ask.answered for ask in asks(recording)):
            fail(
                "the service /detect is there, but never answers",
                expected="a response to every request",
                actual="none",
                at=asks(recording)[0].at,
                recording=recording,
                help="Does main() spin the node? Does the callback return the response?",
            )


@pytest.mark.check(
    points=10, scenarios=("detect_answers", "detect_numbers"), needs=("server_wiring",)
)
def test_answers(recordings: Recordings) -> None:
    """It answers with label, confidence and stamp of the newest scan, as JSON."""
    for recording in recordings:
        require_alive(recording)
        for ask in asks(recording):
            require_detection(recording, ask)


@pytest.mark.check(
    points=5, scenarios=("detect_answers", "detect_readings"), needs=("server_wiring", "answers")
)
def test_features(recordings: Recordings) -> None:
    """The model is asked about the five features of exercise 2."""
    for recording in recordings:
        require_contract(recording)


@pytest.mark.check(points=5, scenarios=("detect_no_scan",), needs=("server_wiring",))
def test_no_scan(recordings: Recordings) -> None:
    """Before the first scan it refuses, and says why."""
    for recording in recordings:
        _require_refusals(recording, "Keep the scan in an attribute that is None at first.")


@pytest.mark.check(points=5, scenarios=("detect_late_scans",), needs=("server_wiring",))
def test_old_scan(recordings: Recordings) -> None:
    """It refuses when the newest scan is older than 1 s, by the stamp in its header."""
    for recording in recordings:
        _require_refusals(
            recording,
            "Compare the node's clock with header.stamp: a scan may have been long on its way.",
        )


@pytest.mark.check(points=5, scenarios=("detect_blind",), needs=("server_wiring",))
def test_blind_sector(recordings: Recordings) -> None:
    """It refuses when a sector of the newest scan has no usable reading, and lives on."""
    for recording in recordings:
        _require_refusals(
            recording, "Only the newest scan counts, even if an older one has more to tell."
        )


@pytest.mark.check(points=5, scenarios=("detect_no_model",), needs=("server_wiring",))
def test_no_model(recordings: Recordings) -> None:
    """Without a model file, or with a broken one, it starts all the same and refuses."""
    for recording in recordings:
        require_alive(recording)
        lives = [p for p in recording.scenario.program if not p.supplied]
        broken, good = lives[:-1], lives[-1]
        for ask in asks(recording):
            if ask.at > good.start:
                require_success(recording, ask)
                continue
            path = next(p.arguments[-1] for p in broken if p.start < ask.at < (p.stop or 0))
            why = f"the server was started with {path}, which can't be loaded"
            require_refusal(recording, ask, why, "Catch whatever pickle.load raises.")


@pytest.mark.check(points=5, scenarios=("detect_failing_model",), needs=("server_wiring",))
def test_failing_model(recordings: Recordings) -> None:
    """It refuses when the model raises or its confidence is not finite, and lives on."""
    for recording in recordings:
        require_alive(recording)
        for ask in asks(recording):
            if "fails" in ask.tags:
                require_refusal(
                    recording,
                    ask,
                    "the model failed",
                    "Put predict and predict_proba into try … except Exception, and test the "
                    "confidence with math.isfinite.",
                )
            else:
                require_success(recording, ask)


@pytest.mark.check(
    points=10, scenarios=("detect_together",), needs=("server_wiring", "client_wiring", "publishes")
)
def test_one_load(recordings: Recordings) -> None:
    """Three clients and one more ask, and the model is loaded once in the whole system."""
    for recording in recordings:
        require_alive(recording)
        heard = detections(recording)
        for role in ROLES:
            if not any(who == role for _, who, _ in heard):
                fail(
                    f"{role}_client never published a detection",
                    expected=f"what the server says, on /{role}/detection",
                    actual="nothing",
                    recording=recording,
                    help="Look at how the server answers when three clients ask at once.",
                )
        for ask in asks(recording):
            require_success(recording, ask)
            loads = re.search(r"load (\d+)", ask.message)
            if loads is None or loads[1] != "1":
                fail(
                    f"by {ask.at:.2f} s the model had been loaded {loads[1]} times"
                    if loads
                    else "the label is not the one that the model gave",
                    expected="one load: in the server's constructor",
                    actual=ask.message,
                    at=ask.at,
                    recording=recording,
                    help="pickle.load belongs into the constructor of the server, and of nobody "
                    "else: that one process has the model is what the service is for.",
                )


# --- the clients: 45 points ----------------------------------------------------------------------


@pytest.mark.check(points=5, scenarios=("detect_slow_server",))
def test_client_wiring(recordings: Recordings) -> None:
    """Each client starts, spins, asks /detect and speaks on the topics of its role."""
    for recording in recordings:
        require_alive(recording)
        _require_own_topics(recording)
        require_wiring(recording, "model_server", *(f"{role}_client" for role in ROLES))
        if not recording.of("/navigation/heartbeat") and not requests(recording):
            fail(
                "the clients start, and then do nothing at all",
                expected="heartbeats and requests",
                actual="none",
                recording=recording,
                help="Does main() spin the node? Does the constructor create the timers, and end?",
            )


@pytest.mark.check(
    points=10, scenarios=("detect_slow_server", "detect_silent_server"), needs=("client_wiring",)
)
def test_never_blocks(recordings: Recordings) -> None:
    """While it waits for an answer, or for none, a client goes on: no callback ever blocks."""
    for recording in recordings:
        require_unblocked(recording)


@pytest.mark.check(
    points=5,
    scenarios=("detect_quick_server", "detect_slow_server", "detect_restart"),
    needs=("client_wiring", "never_blocks"),
)
def test_heartbeat(recordings: Recordings) -> None:
    """A heartbeat every 0.1 s, counting up, without a gap over 0.15 s; with or without a server."""
    for recording in recordings:
        require_heartbeat(recording)


@pytest.mark.check(
    points=5,
    scenarios=("detect_quick_server", "detect_slow_server"),
    needs=("client_wiring", "never_blocks"),
)
def test_asks(recordings: Recordings) -> None:
    """Every client asks every 0.5 s, of a server that takes 0.3 s to answer, too."""
    quick, slow = recordings
    require_alive(quick)
    asked = requests(quick)
    if not asked:
        fail("the client never asks", expected="a request every 0.5 s", recording=quick)
    times = [request.at for request in asked]
    late = times[0] > NEXT_REQUEST + HAIR or quick.duration_s - times[-1] > ASK_PERIOD + HAIR
    gaps = [after - before for before, after in pairwise(times)]
    if late or any(abs(gap - ASK_PERIOD) > HAIR for gap in gaps):
        wrong = next((i for i, gap in enumerate(gaps) if abs(gap - ASK_PERIOD) > HAIR), -1)
        fail(
            "the client does not ask every 0.5 s",
            expected="a request every 0.5 s of a server that answers at once",
            actual=", ".join(f"{time:.2f}" for time in times[:8]) + " s",
            at=times[wrong],
            recording=quick,
            help="One timer of 0.5 s asks, as long as no answer is owed.",
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
    points=5,
    scenarios=("detect_quick_server", "detect_slow_server"),
    needs=("client_wiring", "never_blocks"),
)
def test_publishes(recordings: Recordings) -> None:
    """What the server said is published once, as it is; nothing when it refused."""
    for recording in recordings:
        require_alive(recording)
        answers = [r for r in requests(recording) if r.success]
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
            if not any(text == answer.message for answer in answers):
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
                recording=recording,
            )


@pytest.mark.check(
    points=5, scenarios=("detect_silent_server",), needs=("client_wiring", "never_blocks")
)
def test_gives_up(recordings: Recordings) -> None:
    """One request at a time; without an answer it is given up after 1 s, with a warning."""
    for recording in recordings:
        require_alive(recording)
        found = requests(recording)
        if not any(request.answered == float("inf") for request in found):
            fail("the client asked too seldom to be left without an answer", recording=recording)
        followed = [*found[1:], None]
        for request, after in zip(found, followed, strict=True):
            _require_patience(recording, request, after)


@pytest.mark.check(points=5, scenarios=("detect_restart",), needs=("client_wiring", "never_blocks"))
def test_finds_server(recordings: Recordings) -> None:
    """It starts before the server, outlives it, and finds it again."""
    for recording in recordings:
        require_alive(recording)
        times = [request.at for request in requests(recording)]
        lives = [p for p in recording.scenario.program if p.supplied]
        for number, life in enumerate(lives):
            end = life.stop or recording.duration_s
            first = min((time for time in times if life.start <= time <= end), default=None)
            if first is None or first - life.start > NEXT_REQUEST + HAIR:
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
    points=5, scenarios=("detect_malformed",), needs=("client_wiring", "never_blocks", "publishes")
)
def test_malformed(recordings: Recordings) -> None:
    """Answers that are not what was agreed on are dropped or published; the client goes on."""
    for recording in recordings:
        require_alive(recording)
        found = requests(recording)
        plan = _plan(recording, len(found))
        said = {text for _, _, text in detections(recording)}
        last = recording.duration_s - PUBLISHED_WITHIN
        for number, request in enumerate(found):
            if plan[number] == "fine" and request.answered < last and request.message not in said:
                fail(
                    f"after an answer of the kind “{plan[number - 1]}” a good one is not published",
                    expected=request.message,
                    actual="nothing of the kind on /navigation/detection",
                    at=request.answered,
                    recording=recording,
                    help="Whatever a callback raises on a bad answer, the next one is a new start.",
                )
        end = found[-1].at if found else 0.0
        if recording.duration_s - end > NEXT_REQUEST + HAIR:
            fail(
                f"after an answer of the kind “{plan[len(found) - 1]}” the client asks no more",
                expected="requests until the end of the scenario",
                actual=f"the last at {end:.2f} s",
                at=end,
                recording=recording,
                help="Forget the request before you look at its answer.",
            )


# --- parts of checks -----------------------------------------------------------------------------


def _require_refusals(recording: Recording, help: str) -> None:
    """Fail unless the server refuses where it has to, and only there."""
    require_alive(recording)
    judged = [(ask, allowed(ask.scan, ask.at)) for ask in asks(recording)]
    for ask, right in judged:
        if not right.detection:
            require_refusal(recording, ask, right.reason, help)
        elif not right.refusal:
            require_success(recording, ask)
    kinds = {right.detection for _, right in judged}
    if kinds != {True, False}:
        fail("the scenario ended before its end", recording=recording)


def _require_own_topics(recording: Recording) -> None:
    """Fail if one role speaks on another's topics: it does not look at its parameter."""
    for end in recording.endpoints:
        role = end.node.strip("/").removesuffix("_client")
        other = end.topic.split("/")[1]
        if role in ROLES and end.kind == "publisher" and other in ROLES and other != role:
            fail(
                f"{role}_client publishes on {end.topic}",
                expected=f"topics of its role: /{role}/…",
                actual=f"a publisher on {end.topic}",
                recording=recording,
                help="Read the parameter: self.declare_parameter('role', …).value",
            )


def _require_patience(recording: Recording, request: Request, after: Request | None) -> None:
    """Fail unless the next request comes when this one's answer has come, or is given up."""
    wait = (after.at if after else recording.duration_s) - request.at
    owed = request.answered - request.at > wait  # still, when the next request goes out
    if after and owed and wait < PATIENCE - HAIR:
        fail(
            f"{wait:.2f} s after a request the next went out, though no answer had come",
            expected=f"at most one request at a time; it is given up after {PATIENCE} s",
            actual=f"requests at {request.at:.2f} s and {after.at:.2f} s",
            at=after.at,
            recording=recording,
            help="Remember the future; while it is there and not done, don't ask again.",
        )
    if request.answered - request.at > PATIENCE and wait > NEXT_REQUEST + HAIR:
        fail(
            "a request without an answer is not given up",
            expected=f"the next request {PATIENCE} to {NEXT_REQUEST} s after {request.at:.2f} s",
            actual=f"{wait:.2f} s after it" if after else "no further request",
            at=request.at + NEXT_REQUEST,
            recording=recording,
            help="Remember when you asked; at each tick, compare. remove_pending_request() forgets "
            "the old request.",
        )
    due = request.at + NEXT_REQUEST + HAIR < recording.duration_s
    begin, end = request.at + PATIENCE - HAIR, request.at + NEXT_REQUEST + HAIR
    if request.answered == float("inf") and due and not warnings(recording, begin, end):
        fail(
            "a request was given up without a warning",
            expected=f"a warning in the log between {begin:.2f} s and {end:.2f} s",
            actual="none",
            at=end,
            recording=recording,
            help="self.get_logger().warning(…)",
        )


def _plan(recording: Recording, count: int) -> list[str]:
    """Return the kinds of the first answers of the grader's server; its last word repeats."""
    words = [word for program in recording.scenario.program for word in program.arguments]
    plan = next(word for word in words if word.startswith("answers:="))
    kinds = [word.partition("@")[0] for word in plan.removeprefix("answers:=").split()]
    return kinds + kinds[-1:] * (count - len(kinds))


def _spoken_after(said: list[tuple[float, str, str]], begin: float) -> str:
    spoken = [
        f"{time:.2f} s: {text[:80]}"
        for time, _, text in said
        if 0 <= time - begin <= PUBLISHED_WITHIN
    ]
    return "; ".join(spoken[:3]) or "nothing on /ROLE/detection"
