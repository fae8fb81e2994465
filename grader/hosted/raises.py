"""What a model that the judge keeps may raise: the type travels by its name."""

from __future__ import annotations

RAISES: dict[str, type[Exception]] = {  # what a model may raise, by name
    kind.__name__: kind
    for kind in (
        ArithmeticError,
        AssertionError,
        AttributeError,
        IndexError,
        KeyError,
        MemoryError,
        NotImplementedError,
        OSError,
        RuntimeError,
        TypeError,
        ValueError,
        ZeroDivisionError,
    )
}
