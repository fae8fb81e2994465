"""CDR (XCDR1, little endian) of generated message classes, by their SLOT_TYPES.

Padding is zero; rclpy's own is whatever was in memory. Where Python values of a wrong type end in a
message (Jazzy doesn't check fields by default), what is written imitates rclpy's conversion in C,
which reads the memory of the value as if it were of the right type.
"""

from __future__ import annotations

import array
import importlib
import math
import operator
import struct
import sys
from collections.abc import Callable
from typing import Any, NamedTuple

from rosidl_parser import definition

HEADER = b"\0\1\0\0"  # CDR_LE
CODES = {  # of struct and array
    "boolean": "?", "octet": "B", "char": "B", "byte": "B", "int8": "b", "uint8": "B",
    "int16": "h", "uint16": "H", "int32": "i", "uint32": "I", "int64": "q", "uint64": "Q",
    "float": "f", "double": "d",
}  # fmt: skip
DTYPES = {"b": "i1", "B": "u1", "h": "<i2", "H": "<u2", "i": "<i4", "I": "<u4", "q": "<i8",
          "Q": "<u8", "f": "<f4", "d": "<f8"}  # fmt: skip
COUNT = struct.Struct("<I")
NO_BYTE = 0xDB  # for what is no byte: rclpy reads memory that belongs to nobody
BIG = sys.byteorder == "big"

Write = Callable[[bytearray, Any], None]
Read = Callable[[memoryview, int], tuple[Any, int]]  # data, where; the value, where it ends


class Coder(NamedTuple):
    """How values of one type are written and read."""

    write: Write
    read: Read


def serialize(message: Any) -> bytes:
    """Return a message as CDR.

    Raises AssertionError, TypeError, ValueError, OverflowError: a field's value can't stand in a
    field of its type.
    """
    out = bytearray()
    _of_class(type(message)).write(out, message)
    return HEADER + bytes(out)


def deserialize(data: bytes, cls: Any) -> Any:
    """Return the message that CDR holds.

    Raises RuntimeError: it is too short, or not little-endian.
    """
    if len(data) < len(HEADER) or data[1] != 1:
        raise RuntimeError("failed to deserialize ROS message: expected little-endian CDR")
    try:
        message, _ = _of_class(cls).read(memoryview(data)[len(HEADER) :], 0)
    except (struct.error, ValueError, IndexError) as error:
        raise RuntimeError(f"failed to deserialize ROS message: {error}") from error
    return message


_coders: dict[Any, Coder] = {}  # by class


def _of_class(cls: Any) -> Coder:
    coder = _coders.get(cls)
    if coder is None:
        coder = _coders[cls] = _of_fields(cls)
    return coder


def _of_fields(cls: Any) -> Coder:
    coders = dict(zip(cls._fields_and_field_types, map(_of_type, cls.SLOT_TYPES), strict=True))
    writers = [(name, coder.write) for name, coder in coders.items()]  # of whatever has the names
    readers = [(f"_{name}", coder.read) for name, coder in coders.items()]

    def write(out: bytearray, message: Any) -> None:
        for name, write_field in writers:
            write_field(out, getattr(message, name))
        if not writers:
            out.append(0)  # a structure without members has one in DDS

    def read(data: memoryview, at: int) -> tuple[Any, int]:
        message = cls()
        for name, read_field in readers:
            value, at = read_field(data, at)
            setattr(message, name, value)
        return message, at if readers else at + 1

    return Coder(write, read)


def _of_type(kind: Any) -> Coder:
    if isinstance(kind, definition.BasicType):
        return _of_basic(kind.typename)
    if isinstance(kind, definition.AbstractWString):
        return Coder(_write_wide, _read_wide)
    if isinstance(kind, definition.AbstractGenericString):
        return Coder(_write_string, _read_string)
    if isinstance(kind, definition.NamespacedType):
        return _of_message(_class_of(kind))
    if isinstance(kind, definition.Array):
        return _of_array(kind.value_type, kind.size)
    return _of_sequence(kind.value_type, getattr(kind, "maximum_size", sys.maxsize))


def _class_of(kind: Any) -> Any:
    """Return the class of a message within a message; parts of actions are not exported."""
    package = importlib.import_module(".".join(kind.namespaces))
    whole = getattr(package, kind.name.partition("_")[0])
    return getattr(sys.modules[whole.__module__], kind.name)


def _of_message(cls: Any) -> Coder:
    return Coder(
        lambda out, value: _of_class(cls).write(out, value),
        lambda data, at: _of_class(cls).read(data, at),
    )


# --- numbers -------------------------------------------------------------------------------------


def _of_basic(name: str) -> Coder:
    form = struct.Struct("<" + CODES[name])
    size = form.size
    convert = _conversion(name)
    pack = _pack_float32 if name == "float" else form.pack

    def write(out: bytearray, value: Any) -> None:
        if size > 1:
            out += bytes(-len(out) % size)
        out += pack(convert(value))

    def read(data: memoryview, at: int) -> tuple[Any, int]:
        at += -at % size
        value = form.unpack_from(data, at)[0]
        return (bytes([value]) if name == "octet" else value), at + size

    return Coder(write, read)


def _conversion(name: str) -> Callable[[Any], Any]:
    if name == "octet":
        return lambda value: value[0] if isinstance(value, bytes) and value else NO_BYTE
    if name == "boolean":
        return lambda value: value is True
    if name in ("float", "double"):
        return _as_float
    bits = 8 * struct.calcsize("<" + CODES[name])
    signed = CODES[name].islower()

    def integer(value: Any) -> int:
        number = _as_long(value, signed=signed) & ((1 << bits) - 1)
        return number - (1 << bits) if signed and number >> (bits - 1) else number

    return integer


def _as_long(value: Any, *, signed: bool) -> int:
    """Return what PyLong_AsLongLong or PyLong_AsUnsignedLongLong does; rclpy ignores its error."""
    try:
        if not signed and not isinstance(value, int):
            raise TypeError("an integer is required")
        number = operator.index(value)
        if not (-(2**63) <= number < 2**63 if signed else 0 <= number < 2**64):
            raise OverflowError("Python int too large to convert to C")
    except (TypeError, OverflowError) as error:
        raise SystemError(
            f"the native module returned a result with an exception set: {error}"
        ) from error
    return number


def _as_float(value: Any) -> float:
    """Return what PyFloat_AS_DOUBLE reads: the eight bytes after a Python object's header."""
    if isinstance(value, float):
        return value
    if type(value) in (int, bool):
        return _bits(_size_word(value))
    if hasattr(value, "dtype") and not hasattr(value, "__setitem__"):  # a number, no array
        return _bits(int.from_bytes(value.tobytes()[:8], sys.byteorder))
    shape = getattr(value, "shape", (1,))  # () of an array that is a single number
    return _bits(len(value) if shape and hasattr(value, "__len__") else 1)


def _size_word(number: int) -> int:
    """Return what an int has where a float has its value: the number of its digits, and its sign.

    Source: CPython, Include/cpython/longintrepr.h, of 3.11, of 3.12, and of 3.14, where those that
    are kept for good, -5 to 256, have a bit more.
    """
    digits = (abs(number).bit_length() + 29) // 30
    if sys.version_info >= (3, 12):
        sign = 0 if number > 0 else 1 if number == 0 else 2
        kept = sys.version_info >= (3, 14) and type(number) is int and -5 <= number <= 256
        return digits << 3 | kept << 2 | sign
    return digits if number >= 0 else -digits & (2**64 - 1)


def _bits(word: int) -> float:
    return float(struct.unpack("<d", word.to_bytes(8, "little"))[0])


def _pack_float32(value: float) -> bytes:
    try:
        return struct.pack("<f", value)
    except OverflowError:
        return struct.pack("<f", math.copysign(math.inf, value))


# --- text ----------------------------------------------------------------------------------------


NO_TEXT = "bad argument type for built-in operation"  # as CPython has it


def _write_count(out: bytearray, count: int) -> None:
    out += bytes(-len(out) % 4)
    out += COUNT.pack(count)


def _read_count(data: memoryview, at: int) -> tuple[int, int]:
    at += -at % 4
    (count,) = COUNT.unpack_from(data, at)
    at += 4
    if count > len(data) - at:  # each element takes a byte at least
        raise ValueError(f"{count} elements in {len(data) - at} bytes")
    return count, at


def _write_string(out: bytearray, value: Any) -> None:
    if not isinstance(value, str):
        raise TypeError(NO_TEXT)
    data = value.encode("utf-8").partition(b"\0")[0]  # a text of C's ends there
    _write_count(out, len(data) + 1)
    out += data
    out.append(0)


def _read_string(data: memoryview, at: int) -> tuple[str, int]:
    size, at = _read_count(data, at)
    text = bytes(data[at : at + max(size - 1, 0)])
    return text.decode("utf-8", "replace"), at + size


def _write_wide(out: bytearray, value: Any) -> None:
    if not isinstance(value, str):
        raise TypeError(NO_TEXT)
    data = value.encode("utf-16-le")
    _write_count(out, len(data) // 2)
    for i in range(0, len(data), 2):
        out += data[i : i + 2] + b"\0\0"


def _read_wide(data: memoryview, at: int) -> tuple[str, int]:
    count, at = _read_count(data, at)
    units = b"".join(bytes(data[at + 4 * i : at + 4 * i + 2]) for i in range(count))
    return units.decode("utf-16-le", "replace"), at + 4 * count


# --- many of one type ----------------------------------------------------------------------------


def _code_of_block(kind: Any) -> str:
    """Return the code of elements that are written as one block; "" if each is written alone."""
    if isinstance(kind, definition.BasicType) and kind.typename not in ("boolean", "octet"):
        return CODES[kind.typename]
    return ""


def _write_block(out: bytearray, value: Any, code: str) -> None:
    out += bytes(-len(out) % struct.calcsize("<" + code))
    block = value if hasattr(value, "tobytes") else array.array(code, value)
    if BIG:
        block = array.array(code, block)
        block.byteswap()
    out += block.tobytes()


def _of_sequence(kind: Any, most: int) -> Coder:
    element, code = _of_type(kind), _code_of_block(kind)
    size = struct.calcsize("<" + code) if code else 0

    def write(out: bytearray, value: Any) -> None:
        if len(value) > most:
            raise AssertionError(f"expected at most {most} elements, got {len(value)}")
        _write_count(out, len(value))
        if not code:
            for entry in value:
                element.write(out, entry)
        elif len(value):
            _write_block(out, value, code)

    def read(data: memoryview, at: int) -> tuple[Any, int]:
        count, at = _read_count(data, at)
        if not code:
            return _read_each(element.read, data, at, count)
        values = array.array(code)
        if count:
            at += -at % size
            values.frombytes(data[at : at + count * size])
            if len(values) != count:
                raise ValueError(f"{count} elements announced, {len(values)} there")
            if BIG:
                values.byteswap()
        return values, at + count * size

    return Coder(write, read)


def _of_array(kind: Any, count: int) -> Coder:
    element, code = _of_type(kind), _code_of_block(kind)
    size = struct.calcsize("<" + code) if code else 0

    def write(out: bytearray, value: Any) -> None:
        if len(value) != count:
            raise AssertionError(f"expected {count} elements, got {len(value)}")
        if code:
            _write_block(out, value, code)
            return
        for entry in value:
            element.write(out, entry)

    def read(data: memoryview, at: int) -> tuple[Any, int]:
        if not code:
            return _read_each(element.read, data, at, count)
        import numpy as np  # noqa: PLC0415  (most messages have no arrays)

        at += -at % size
        block = np.frombuffer(data[at : at + count * size], dtype=DTYPES[code])
        if len(block) != count:
            raise ValueError(f"expected {count} elements, got {len(block)}")
        return block.astype(block.dtype.newbyteorder("=")), at + count * size

    return Coder(write, read)


def _read_each(read: Read, data: memoryview, at: int, count: int) -> tuple[list[Any], int]:
    values = []
    for _ in range(count):
        value, at = read(data, at)
        values.append(value)
    return values, at
