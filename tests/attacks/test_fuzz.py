"""Whatever comes through the pipe: the judge takes it for what it is, or for forged; nothing else.

Noise, damaged frames, and well-formed MessagePack with the right keys and the wrong values, for
each of the judge's decoders.
"""

import struct
from collections.abc import Callable
from typing import Any

import msgspec
import pytest
from arena import FULL
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from grader.colcon.frames import Executable, PackageRead
from grader.hosted.models import Loaded, Predicted, Tensor
from grader.hosted.questions import Question
from rclpy_virtual_time.host.frames import (
    LENGTH,
    Carried,
    Ended,
    EndpointReport,
    HeardNow,
    Published,
    Pulse,
    Settled,
    Tuned,
    decode_from_live,
    decode_from_radio,
    decode_from_script,
    decode_to_judge,
    encode,
)
from rclpy_virtual_time.link.exchange import HostForged, decoded
from rclpy_virtual_time.link.pipes import Channel

DECODERS: dict[str, tuple[Callable[[bytes], Any], tuple[type, ...]]] = {
    "nodes": (decode_to_judge, (Settled, Ended)),
    "live": (decode_from_live, (Pulse, Ended)),
    "radio": (decode_from_radio, (Tuned, HeardNow)),
    **{
        kind.__name__: (msgspec.msgpack.Decoder(kind).decode, (kind,))
        for kind in (PackageRead, Loaded, Predicted, Question)
    },
    "scripts": (decode_from_script, (Ended, Carried)),
}
GOOD = (
    Settled(5, True, False, [Published(1, "/cmd_vel", "a/msg/B", b"x" * 60)]),
    Ended(5, "returned", "text", "detail", [], [EndpointReport("client", "/n", "/t", "a/srv/B")]),
    Pulse(
        1_700_000_000,
        0.5,
        [EndpointReport("publisher", "/n", "/t", "a/msg/B")],
        {"publisher /t": 1},
    ),
    Tuned([EndpointReport("subscription", "/n", "/t", "a/msg/B")], {"subscription /t": 2}),
    HeardNow([Published(2**60, "/t", "a/msg/B", b"")]),
    Carried(bytes(40)),
)
CARRIED = (  # what tasks and questions hold
    PackageRead(executables=(Executable("one", "mine/one.py", "mine.one:main"),)),
    Loaded({"a.pkl": ""}, (Tensor("tensor(float)", ("", "5")),)),
    Predicted("", (1, 5), bytes(40)),
    Question("predict", "a.pkl", 1, 1, bytes(40)),
)
BODIES = [encode(frame)[LENGTH.size :] for frame in GOOD]
BODIES += [msgspec.msgpack.encode(each) for each in CARRIED]
DECODED = map(msgspec.msgpack.decode, BODIES)
KEYS = sorted({key for fields in DECODED if isinstance(fields, dict) for key in fields})
TAGS = ("settled", "ended", "pulse", "tuned", "heard", "carried", "start", "", 7)

fixed = settings(
    derandomize=True,
    deadline=None,
    max_examples=300 if FULL else 30,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
leaves = (
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**64 - 1)
    | st.floats()
    | st.text(max_size=20)
    | st.binary(max_size=20)
    | st.sampled_from(["x" * 300, b"y" * 30_000, "/cmd_vel", "publisher", "returned"])
)
values = st.recursive(
    leaves,
    lambda inner: st.lists(inner, max_size=6) | st.dictionaries(st.text(max_size=9), inner),
    max_leaves=8,
)
messages = st.lists(st.tuples(leaves, leaves, leaves, leaves).map(list), max_size=3)
frames = st.builds(
    lambda tag, fields: {"type": tag, **fields},
    st.sampled_from(TAGS),
    st.dictionaries(st.sampled_from(KEYS), values | messages, max_size=8),
)


def hear(name: str, body: bytes) -> None:
    """Decode as the judge does."""
    decode, kinds = DECODERS[name]
    try:
        frame = decoded(body, decode)
    except HostForged as error:
        assert len(str(error)) <= 300
    else:
        assert isinstance(frame, kinds)


@pytest.mark.parametrize("name", DECODERS)
@fixed
@given(noise=st.binary(max_size=400))
def test_noise(name: str, noise: bytes) -> None:
    hear(name, noise)


@pytest.mark.parametrize("name", DECODERS)
@fixed
@given(frame=frames)
def test_right_keys_and_wrong_values(name: str, frame: dict[str, Any]) -> None:
    hear(name, msgspec.msgpack.encode(frame))


@pytest.mark.parametrize("name", DECODERS)
@fixed
@given(body=st.sampled_from(BODIES), data=st.data())
def test_damaged_frames(name: str, body: bytes, data: st.DataObject) -> None:
    damaged = bytearray(body)
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(damaged) - 1))
        damaged[at : at + data.draw(st.integers(0, 3))] = data.draw(st.binary(max_size=3))
        damaged = damaged or bytearray(b"\0")
    hear(name, bytes(damaged))


DEEP = {
    "lists": b"\x91" * 200_000 + b"\xc0",
    "maps": b"\x81\xa1a" * 200_000 + b"\xc0",
    "keys": b"\x81" * 200_000 + b"\xc0",
    "a list that promises much": b"\xdd" + struct.pack(">I", 2**32 - 1),
    "a text that promises much": b"\xdb" + struct.pack(">I", 2**32 - 1) + b"x",
    "an extension": b"\xc9" + struct.pack(">I", 2**31) + b"\x01",
    "a time": b"\xd7\xff" + bytes(8),
    "half a character": b"\x81\xa4type\xa2\xc3(",
    "nothing": b"",
    "a frame and more": BODIES[0] + b"\xc0",
    "a key twice": b"\x82\xa4type\xa7settled\xa4type\xa5ended",
    "lists in a known field": b"\x82\xa4type\xa7settled\xa9published" + b"\x91" * 100_000,
    "lists in an unknown field": b"\x82\xa4type\xa7settled\xa1z" + b"\x91" * 100_000 + b"\xc0",
}


@pytest.mark.parametrize("name", DECODERS)
@pytest.mark.parametrize("what", DEEP)
def test_traps(name: str, what: str) -> None:
    hear(name, DEEP[what])


class _Pipe(Channel):
    """The judge's buffer, without a host."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    def take(self, chunk: bytes) -> list[bytes]:
        self._buffer += chunk
        found = []
        while (body := self._take_frame()) is not None:
            found.append(body)
        return found


@fixed
@given(chunks=st.lists(st.binary(max_size=40) | st.sampled_from(BODIES), max_size=12))
def test_any_stream_is_frames_or_forged(chunks: list[bytes]) -> None:
    pipe = _Pipe()
    taken = 0
    try:
        for chunk in chunks:
            for body in pipe.take(chunk):
                taken += LENGTH.size + len(body)
                for name in DECODERS:
                    hear(name, body)
    except HostForged:
        return
    assert taken + len(pipe._buffer) == sum(map(len, chunks))


@fixed
@given(bodies=st.lists(st.sampled_from(BODIES), max_size=5), cuts=st.data())
def test_frames_arrive_however_they_are_cut(bodies: list[bytes], cuts: st.DataObject) -> None:
    stream = b"".join(LENGTH.pack(len(body)) + body for body in bodies)
    pipe, found = _Pipe(), []
    while stream:
        size = cuts.draw(st.integers(1, 50))
        found += pipe.take(stream[:size])
        stream = stream[size:]
    assert found == bodies
