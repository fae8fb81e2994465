"""What a server or a client always does wrong: a mistake is named, and paid for, once.

`answers` and `no_scan` judge what a server says, `never_blocks` and `publishes` what its clients
do. Other checks take as given what they found, and only where one of them has failed.
"""

from __future__ import annotations

from grader.checks.verdict import passes
from grader.exercises.model_server.answers import Ask, asks, parsed, require_detection
from grader.exercises.model_server.clients import require_own_topics, require_unblocked
from grader.exercises.model_server.contract import allowed
from grader.recording import Recording

SAYS, EARLY = "detect_answers", "detect_no_scan"  # scenarios that show a server's habits
SLOW = "detect_slow_server"  # shows the clients'


def trusts_success(says: Recording, early: Recording | None = None) -> bool:
    """Tell whether `success` may be trusted; if not, an object in the message is a detection.

    It is false with every detection, so that `answers` fails, or true with a refusal before the
    first scan, so that `no_scan` fails.
    """
    told = asks(says)
    if told and all(not ask.success and claims(ask) for ask in told):
        return False
    return early is None or not any(
        ask.success and ask.message.strip() and not claims(ask)
        for ask in asks(early)
        if not allowed(ask.scan, ask.at).detection
    )


def gives_reasons(early: Recording) -> bool:
    """Tell whether the server says why when it refuses; if not, `no_scan` fails."""
    return all(ask.success or ask.message.strip() for ask in asks(early) if ask.answered)


def claims(ask: Ask) -> bool:
    """Tell whether an answer's message is an object, as a detection is."""
    try:
        return isinstance(parsed(ask.message), dict)
    except (ValueError, RecursionError):
        return False


def says_right(says: Recording) -> bool:
    """Tell whether all plain answers are detections as the contract wants them."""
    return all(passes(require_detection, says, ask) for ask in asks(says))


def goes_on(slow: Recording) -> bool:
    """Tell whether no client stands still, and each speaks on the topics of its role."""
    return is_unblocked(slow) and passes(require_own_topics, slow)


def is_unblocked(slow: Recording) -> bool:
    """Tell whether no client stands still while it waits for an answer."""
    return passes(require_unblocked, slow)
