"""What goes into a frame comes out of it; anything else is refused."""

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grader.host.frames import (
    LENGTH,
    MAX_FRAME,
    MAX_NAME,
    MAX_PUBLISHED,
    MAX_TEXT,
    Delivery,
    Ended,
    EndpointReport,
    Offer,
    ProgramStart,
    Published,
    Run,
    Settled,
    Start,
    decode_to_host,
    decode_to_judge,
    encode,
)

REFUSALS = (msgspec.DecodeError, UnicodeDecodeError, RecursionError)
fixed = settings(derandomize=True, deadline=None, max_examples=60)

names = st.text(st.characters(exclude_categories=["Cs"]), max_size=MAX_NAME)
texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=200)
times = st.integers(0, 2**62)
data = st.binary(max_size=200)
published = st.lists(st.builds(Published, times, names, names, data), max_size=5)
endpoints = st.lists(
    st.builds(
        EndpointReport,
        kind=st.sampled_from(["publisher", "subscription", "service", "client"]),
        node=names,
        topic=names,
        type=names,
        reliability=names,
        durability=names,
        depth=st.integers(-(2**63), 2**63 - 1),
        mismatch=texts,
    ),
    max_size=5,
)
settled = st.builds(Settled, times, st.booleans(), st.booleans(), published, endpoints)
ended = st.builds(
    Ended,
    times,
    st.sampled_from(["returned", "exited", "exception", "syntax_error", "flooded"]),
    texts,
    texts,
    published,
    endpoints,
)
programs = st.builds(
    ProgramStart,
    file=texts,
    arguments=st.lists(texts, max_size=3).map(tuple),
    start=times,
    stop=st.none() | times,
)
starts = st.builds(
    Start,
    programs=st.lists(programs, max_size=3).map(tuple),
    epoch=times,
    seed=st.integers(0, 2**31),
    offers=st.lists(st.builds(Offer, names, names, st.booleans()), max_size=3).map(tuple),
)
runs = st.builds(Run, times, st.lists(st.builds(Delivery, names, data), max_size=5).map(tuple))


def body(encoded: bytes) -> bytes:
    (length,) = LENGTH.unpack_from(encoded)
    assert length == len(encoded) - LENGTH.size
    return encoded[LENGTH.size :]


@fixed
@given(settled | ended)
def test_what_a_host_says_arrives(frame: Settled | Ended) -> None:
    assert decode_to_judge(body(encode(frame))) == frame


@fixed
@given(starts | runs)
def test_what_the_judge_says_arrives(frame: Start | Run) -> None:
    assert decode_to_host(body(encode(frame))) == frame


GOOD = {"type": "settled", "now": 0, "spinning": True, "asleep": False, "published": []}
WRONG = {
    "another type": {**GOOD, "type": "start"},
    "time as text": {**GOOD, "now": "0"},
    "time before the start": {**GOOD, "now": -1},
    "time without end": {**GOOD, "now": 2**62 + 1},
    "a message too many": {**GOOD, "published": [[0, "/a", "b", b""]] * (MAX_PUBLISHED + 1)},
    "a topic too long": {**GOOD, "published": [[0, "x" * (MAX_NAME + 1), "b", b""]]},
    "a type that is bytes": {**GOOD, "published": [[0, "/a", b"b", b""]]},
    "endpoints without end": {**GOOD, "endpoints": [["client", "n", "/t", "x"]] * 501},
    "a reason too long": {
        **GOOD,
        "endpoints": [["client", "n", "/t", "x", "", "", 0, "m" * (MAX_TEXT + 1)]],
    },
    "an end of no kind": {**GOOD, "type": "ended", "kind": "completed", "text": "", "detail": ""},
    "a text too long": {
        **GOOD,
        "type": "ended",
        "kind": "returned",
        "text": "x" * (MAX_TEXT + 1),
        "detail": "",
    },
}


def test_the_pattern_of_the_wrong_frames_is_right() -> None:
    assert decode_to_judge(msgspec.msgpack.encode(GOOD)) == Settled(0, True, False, [])


@pytest.mark.parametrize("what", WRONG)
def test_each_field_is_checked(what: str) -> None:
    with pytest.raises(REFUSALS):
        decode_to_judge(msgspec.msgpack.encode(WRONG[what]))


def test_a_frame_that_the_link_can_not_carry_is_not_made() -> None:
    with pytest.raises(ValueError, match=f"the link carries {MAX_FRAME}"):
        encode(Run(0, (Delivery("/scan", bytes(MAX_FRAME)),)))
