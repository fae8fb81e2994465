"""Which functions bring a stamped message into another frame, by its type."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from .exceptions import TransformException


class TypeException(TransformException):
    """Nothing is registered for a type."""

    def __init__(self, errstr: str) -> None:
        self.errstr = errstr
        super().__init__(errstr)


class _Registration:
    """Functions by type, one table for the whole process."""

    def _get(self, table: dict[Any, Any], key: Any) -> Callable[..., Any]:
        found: Callable[..., Any] | None = table.get(key)
        if found is None:
            raise TypeException(f"Type {key} is not loaded or supported")
        return found


class TransformRegistration(_Registration):
    """What brings a message of a type into another frame."""

    _table: ClassVar[dict[Any, Any]] = {}

    def add(self, key: Any, callback: Callable[[Any, Any], Any]) -> None:
        """Register a function of a stamped object and a TransformStamped."""
        self._table[key] = callback

    def get(self, key: Any) -> Callable[[Any, Any], Any]:
        """Return it; raises TypeException."""
        return self._get(self._table, key)


class ConvertRegistration(_Registration):
    """What makes one type of another."""

    _to_msg: ClassVar[dict[Any, Any]] = {}
    _from_msg: ClassVar[dict[Any, Any]] = {}
    _convert: ClassVar[dict[Any, Any]] = {}

    def add_to_msg(self, key: Any, callback: Callable[[Any], Any]) -> None:
        """Register what makes a message of a type."""
        self._to_msg[key] = callback

    def add_from_msg(self, key: Any, callback: Callable[[Any], Any]) -> None:
        """Register what makes a type of a message."""
        self._from_msg[key] = callback

    def add_convert(self, key: Any, callback: Callable[[Any], Any]) -> None:
        """Register what makes the second type of a pair of the first."""
        self._convert[key] = callback

    def get_to_msg(self, key: Any) -> Callable[[Any], Any]:
        """Return it; raises TypeException."""
        return self._get(self._to_msg, key)

    def get_from_msg(self, key: Any) -> Callable[[Any], Any]:
        """Return it; raises TypeException."""
        return self._get(self._from_msg, key)

    def get_convert(self, key: Any) -> Callable[[Any], Any]:
        """Return it; raises TypeException."""
        return self._get(self._convert, key)


def convert(a: Any, b_type: Any) -> Any:
    """Return an object as another type; raises TypeException."""
    registration = ConvertRegistration()
    try:
        return registration.get_convert((type(a), b_type))(a)
    except TypeException:
        if type(a) is b_type:
            return a
        return registration.get_from_msg(b_type)(registration.get_to_msg(type(a))(a))
