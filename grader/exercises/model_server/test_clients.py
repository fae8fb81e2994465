"""The core checks of exercise 6's clients, 40 points: how they ask the grader's own server."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.check import DECISION, STATE, TIMING, WIRING, check
from grader.checks.verbs import wired
from grader.exercises.model_server.clients import ROLES, beats, warns
from grader.exercises.model_server.contract import keeps

QUICK, SLOW = "detect_quick_server", "detect_slow_server"
SILENT, RESTART, MALFORMED = "detect_silent_server", "detect_restart", "detect_malformed"
PUBLISHES = (QUICK, SLOW, SILENT, "detect_default_role")
DETECTION, HEARTBEAT = "/ROLE/detection", "/ROLE/heartbeat"
WIRED = ("client_wiring",)
NEEDS = ("client_wiring", "never_blocks")
READS = (*NEEDS, "publishes")


@check(points=5, asks=WIRING, task=5, scenarios=(SLOW,), needs=())
def test_client_wiring(runs: Runs) -> None:
    """The client starts, spins, asks /detect and publishes on its topics."""
    wired(runs, "navigation_client")


@check(points=10, asks=TIMING, task=6, scenarios=(SLOW, SILENT), needs=WIRED, hint="6.1")
def test_never_blocks(runs: Runs) -> None:
    """A client asks, and goes on whether or not an answer comes: no callback ever blocks."""
    help = (
        "Does a callback wait: client.call(), await in the default callback group, "
        "spin_until_future_complete(), a sleep, a loop? While it waits, its executor delivers "
        "nothing, not even the answer that it waits for. Use call_async() and "
        "future.add_done_callback(), and return."
    )
    keeps(runs, "goes_on", topic=HEARTBEAT, help=help)


@check(points=10, asks=TIMING, task=5, scenarios=(QUICK, SLOW, RESTART), needs=WIRED, hint="5.1")
def test_heartbeat(runs: Runs) -> None:
    """A heartbeat every 0.1 s, counting up, without a gap over 0.15 s; with or without a server."""
    for recording in runs:
        beats(recording)
    help = "self.create_timer(0.1, …); keep the count in an attribute, and add 1 each time."
    keeps(runs, "beats", topic=HEARTBEAT, help=help)


@check(points=3, asks=TIMING, task=6, scenarios=(QUICK,), needs=NEEDS, hint="6.1")
def test_asks(runs: Runs) -> None:
    """Every client asks every 0.5 s, of a server that takes 0.3 s to answer, too."""
    help = "One timer of 0.5 s asks: the time counts from one request to the next, not the answer."
    keeps(runs, "found", "rhythm", help=help)


@check(points=3, asks=DECISION, task=6, scenarios=PUBLISHES, needs=NEEDS, hint="6.2")
def test_publishes(runs: Runs) -> None:
    """What the server said is published once, on the topic of the role; nothing if it refused."""
    wired(runs.only(SLOW), *(f"{role}_client" for role in ROLES))
    help = (
        "When the future is done, and nowhere else: String(data=response.message), if success, on "
        "the topic of self.declare_parameter('role', 'navigation').value"
    )
    keeps(runs, "publish", topic=DETECTION, help=help)


@check(points=3, asks=STATE, task=7, scenarios=(SILENT, RESTART), needs=NEEDS, hint="7.2")
def test_gives_up(runs: Runs) -> None:
    """One request at a time; without an answer it is given up after 1 s, with a warning."""
    help = (
        "Remember the future and when you asked; while it is not done, don't ask again; at each "
        "tick, compare. remove_pending_request() forgets it: what comes late answers another one."
    )
    keeps(runs.only(SILENT), "patience", help=help)
    for recording in runs:
        warns(recording)  # a client may see that its server has gone, and say so


@check(points=3, asks=STATE, task=8, scenarios=(RESTART,), needs=NEEDS, hint="8.1")
def test_finds_server(runs: Runs) -> None:
    """It starts before the server, outlives it, and finds it again."""
    help = (
        "Look for the server at every tick, not once; and give up a request that the old server "
        "took with it."
    )
    keeps(runs, "found", help=help)


@check(points=3, asks=STATE, task=8, scenarios=(MALFORMED,), needs=READS, hint="8.2")
def test_malformed(runs: Runs) -> None:
    """Malformed answers are dropped or published, and the client goes on."""
    help = "Forget the request before you look at its answer: the next one is a new start."
    keeps(runs, "publish", topic=DETECTION, help=help)
    keeps(runs, "patience", help=help)
