"""What the page uses of msgspec, for a Python for which it has no wheel.

Structs are dataclasses. `convert` trusts what it gets: it reads the course's own scenarios and
worlds, which msgspec itself has checked when the page was built.
"""

from __future__ import annotations

import dataclasses
import json as _json
import types
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from . import inspect, msgpack, structs

__all__ = ["inspect", "json", "msgpack", "structs"]

NODEFAULT = dataclasses.MISSING


class MsgspecError(Exception):
    """What goes wrong here."""


class DecodeError(MsgspecError):
    """The bytes are not what was expected."""


class ValidationError(DecodeError):
    """The values are not what was expected."""


class Raw(bytes):
    """Bytes that stay as they are."""


class Meta:
    """Constraints of a type; ignored by this stand-in."""

    def __init__(self, **bounds: Any) -> None:
        self.bounds = bounds


class Struct:
    """A dataclass, made by inheriting."""

    def __init_subclass__(
        cls, *, frozen: bool = False, rename: dict[str, str] | None = None, **_: Any
    ) -> None:
        super().__init_subclass__()
        cls.__renamed__ = {there: here for here, there in (rename or {}).items()}
        for name in cls.__annotations__:
            default = cls.__dict__.get(name)
            if isinstance(default, list | dict | set):
                setattr(cls, name, dataclasses.field(default_factory=default.copy))
        dataclasses.dataclass(frozen=frozen)(cls)

    def __reduce__(self) -> Any:
        return type(self), structs.astuple(self)


def convert(value: Any, type: Any) -> Any:
    """Return a value of JSON's or TOML's types as another type."""
    origin, arguments = get_origin(type), get_args(type)
    if origin is Annotated:
        return convert(value, arguments[0])
    if origin in (Union, types.UnionType):
        return _one_of(value, arguments)
    if origin in (list, tuple, set, frozenset) and arguments:
        return origin(_items(value, origin, arguments))
    if origin is dict:
        return {key: convert(each, arguments[1]) for key, each in value.items()}
    if dataclasses.is_dataclass(type) and isinstance(value, dict):
        return _struct(value, type)
    if type is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if type in (str, bool, float, int, dict) and not isinstance(value, type):
        raise ValidationError(f"Expected `{type.__name__}`, got {value!r}")
    if origin is Literal and value not in arguments:
        raise ValidationError(f"Invalid enum value {value!r}")
    return value


def _one_of(value: Any, arguments: tuple[Any, ...]) -> Any:
    if value is None:
        return None
    exact = [each for each in arguments if each is builtin(value)]
    for each in exact or [each for each in arguments if each is not types.NoneType]:
        try:
            return convert(value, each)
        except (ValidationError, TypeError, AttributeError):
            continue
    raise ValidationError(f"{value!r} is none of {arguments}")


def _items(value: Any, origin: Any, arguments: tuple[Any, ...]) -> list[Any]:
    if isinstance(value, str) or not hasattr(value, "__len__"):
        raise ValidationError(f"Expected `array`, got {value!r}")
    if origin is tuple and arguments[-1] is not Ellipsis:
        if len(value) != len(arguments):
            raise ValidationError(f"Expected `array` of length {len(arguments)}")
        return [convert(each, kind) for each, kind in zip(value, arguments, strict=True)]
    return [convert(each, arguments[0]) for each in value]


def _struct(value: dict[str, Any], kind: Any) -> Any:
    hints, renamed = _hints(kind), kind.__renamed__
    try:
        here = {renamed.get(name, name): each for name, each in value.items()}
        return kind(**{name: convert(each, hints[name]) for name, each in here.items()})
    except (KeyError, TypeError, ValueError) as error:
        raise ValidationError(str(error)) from error


_known: dict[Any, dict[str, Any]] = {}


def _hints(kind: Any) -> dict[str, Any]:
    if kind not in _known:
        _known[kind] = get_type_hints(kind, include_extras=True)
    return _known[kind]


def to_builtins(value: Any) -> Any:
    """Return what JSON can say of a value."""
    if dataclasses.is_dataclass(value):
        return {f.name: to_builtins(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {key: to_builtins(each) for key, each in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [to_builtins(each) for each in value]
    return value


class json:
    """JSON."""

    @staticmethod
    def encode(value: Any) -> bytes:
        """Return a value as JSON."""
        return _json.dumps(to_builtins(value), separators=(",", ":"), ensure_ascii=False).encode()

    @staticmethod
    def decode(data: bytes | str, type: Any = Any) -> Any:
        """Return what JSON says as another type."""
        return convert(_json.loads(data), type)


builtin = type
