"""What goes into a frame comes out of it; anything else is refused.

tests/attacks/test_fuzz.py damages frames for every decoder.
"""

import msgspec
import pytest

from rclpy_virtual_time.host import frames

REFUSALS = (msgspec.DecodeError, UnicodeDecodeError, RecursionError)
SAID = [
    frames.Published(2**62, "/t", "a/msg/B", bytes(range(256))),
    frames.Published(0, "", "ü" * frames.MAX_NAME, b""),
]
ENDS = [
    frames.EndpointReport(kind, "/n", "/t", "a/msg/B", "reliable", "volatile", -(2**63), "why not")
    for kind in ("publisher", "subscription", "service", "client")
]
TO_JUDGE = (
    frames.Settled(0, True, False, []),
    frames.Settled(2**62, False, True, SAID, ENDS),
    frames.Ended(5, "flooded", "text", "detail", SAID, ENDS),
    frames.Ended(0, "returned", "", "\x00\n\u2028", []),
)
TO_HOST = (
    frames.Start(
        (frames.ProgramStart("a.py", ("-p", "x"), 5), frames.ProgramStart("b.py", (), 0, 2**62)),
        epoch=2**62, seed=2**31, offers=(frames.Offer("/scan", "a/msg/B", True),)),
    frames.Run(2**62, (frames.Delivery("/scan", bytes(1_000_000)), frames.Delivery("", b""))),
)  # fmt: skip


def body(encoded: bytes) -> bytes:
    (length,) = frames.LENGTH.unpack_from(encoded)
    assert length == len(encoded) - frames.LENGTH.size
    return encoded[frames.LENGTH.size :]


@pytest.mark.parametrize("frame", TO_JUDGE)
def test_what_a_host_says_arrives(frame: frames.Settled | frames.Ended) -> None:
    assert frames.decode_to_judge(body(frames.encode(frame))) == frame


@pytest.mark.parametrize("frame", TO_HOST)
def test_what_the_judge_says_arrives(frame: frames.Start | frames.Run) -> None:
    assert frames.decode_to_host(body(frames.encode(frame))) == frame


GOOD = {"type": "settled", "now": 0, "spinning": True, "asleep": False, "published": []}
WRONG = {
    "another type": {**GOOD, "type": "start"},
    "time as text": {**GOOD, "now": "0"},
    "time before the start": {**GOOD, "now": -1},
    "time without end": {**GOOD, "now": 2**62 + 1},
    "a message too many": {**GOOD, "published": [[0, "/a", "b", b""]] * (frames.MAX_PUBLISHED + 1)},
    "a topic too long": {**GOOD, "published": [[0, "x" * (frames.MAX_NAME + 1), "b", b""]]},
    "a type that is bytes": {**GOOD, "published": [[0, "/a", b"b", b""]]},
    "endpoints without end": {**GOOD, "endpoints": [["client", "n", "/t", "x"]] * 501},
    "a reason too long": {
        **GOOD,
        "endpoints": [["client", "n", "/t", "x", "", "", 0, "m" * (frames.MAX_TEXT + 1)]],
    },
    "an end of no kind": {**GOOD, "type": "ended", "kind": "completed", "text": "", "detail": ""},
    "a text too long": {
        **GOOD,
        "type": "ended",
        "kind": "returned",
        "text": "x" * (frames.MAX_TEXT + 1),
        "detail": "",
    },
}


def test_the_pattern_of_the_wrong_frames_is_right() -> None:
    assert frames.decode_to_judge(msgspec.msgpack.encode(GOOD)) == frames.Settled(
        0, True, False, []
    )


@pytest.mark.parametrize("what", WRONG)
def test_each_field_is_checked(what: str) -> None:
    with pytest.raises(REFUSALS):
        frames.decode_to_judge(msgspec.msgpack.encode(WRONG[what]))


def test_a_frame_that_the_link_can_not_carry_is_not_made() -> None:
    with pytest.raises(ValueError, match=f"the link carries {frames.MAX_FRAME}"):
        frames.encode(frames.Run(0, (frames.Delivery("/scan", bytes(frames.MAX_FRAME)),)))
