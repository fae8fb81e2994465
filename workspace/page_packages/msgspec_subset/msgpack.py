"""Bytes that never leave the page's process: pickles."""

import pickle
from typing import Any


class Encoder:
    """Encodes anything."""

    encode = staticmethod(pickle.dumps)

    def __init__(self, enc_hook: Any = None) -> None:
        pass


class Decoder:
    """Decodes what was encoded here, whatever its type is."""

    decode = staticmethod(pickle.loads)

    def __init__(self, type: Any = Any) -> None:
        pass


def decode(data: bytes, type: Any = Any) -> Any:
    """Return what was encoded."""
    return pickle.loads(data)


def encode(value: Any) -> bytes:
    """Return bytes; of nothing those of MessagePack, which are part of a recording's digest."""
    return b"\x90" if isinstance(value, tuple) and not value else pickle.dumps(value)
