"""Frames go through no pipe in the page."""

from typing import Any


class Encoder:
    """Encodes nothing."""

    def encode(self, value: Any) -> bytes:
        """Refuse."""
        raise NotImplementedError("nothing is encoded in the page")


class Decoder:
    """Decodes nothing."""

    def __init__(self, type: Any = Any) -> None:
        pass

    def decode(self, data: bytes) -> Any:
        """Refuse."""
        raise NotImplementedError("nothing is decoded in the page")


encode, decode = Encoder().encode, Decoder().decode
