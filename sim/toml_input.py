"""Reading a TOML file into frozen structs, with errors for the person who wrote the file.

Every mistake becomes an `InputError` of one line: the file, the key, the value, what was expected,
and for an unknown key or name the nearest one that exists.
"""

import difflib
import json
import math
import re
import tomllib
from collections.abc import Collection, Iterable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from sim.errors import InputError

T = TypeVar("T")
Key = tuple[str | int, ...]

_WORDS = {
    "float": "a number",
    "int": "a whole number",
    "str": "a string",
    "bool": "true or false",
    "array": "a list",
    "object": "a table",
}
_PATH = re.compile(r"(?P<what>.*) - at `(?P<path>\$.*)`", re.DOTALL)
_UNKNOWN = re.compile(r"Object contains unknown field `(.*)`")
_MISSING = re.compile(r"Object missing required field `(.*)`")
_LENGTH = re.compile(r"Expected `array` of (?:at least )?length (?P<want>[<>=]* ?\d+)")
_BOUND = re.compile(r"Expected `(?P<type>float|int)(?: \| null)?` [<>].*")
_OURS = re.compile(r"(?P<key>\w+): (?P<what>.*)")  # a __post_init__ that names its field
_MAX_BYTES = 4_000_000
NEAR, SURE = 0.5, 0.85  # likeness of names: perhaps, certainly
FEW = 6  # names that are near
MANY = 12  # names: more would bury the message
_MAX_SHOWN = 60  # characters of a value in an error


def read_toml(path: Path) -> str:
    """Return the text of a TOML file.

    Raises InputError: the file is missing, is a folder, is not UTF-8, or has over 4 MB.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(f"{path}: cannot read this file: {reason}") from None
    if len(data) > _MAX_BYTES:
        raise InputError(f"{path}: {len(data)} bytes, expected at most {_MAX_BYTES}")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not UTF-8 text (byte {error.start})") from None


def parse_toml(text: str, where: str) -> dict[str, Any]:
    """Return the table in a TOML text; `where` names it in errors.

    Raises InputError: the text is not TOML.
    """
    try:
        return _tables(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        reason = str(error).splitlines()[0]
        raise InputError(f"{where}: not valid TOML: {reason}") from None


@lru_cache(maxsize=256)  # a trial's scenario is read several times; nobody changes a table
def _tables(text: str) -> dict[str, Any]:
    return tomllib.loads(text)


def merged(base: dict[str, Any], own: dict[str, Any]) -> dict[str, Any]:
    """Return `base` overridden by `own`: table by table, any other value as a whole."""
    result = dict(base)
    for key, value in own.items():
        inherited = result.get(key)
        if isinstance(inherited, dict) and isinstance(value, dict):
            result[key] = merged(inherited, value)
        else:
            result[key] = value
    return result


def convert(
    doc: Any, type_: type[T], where: str, *, at: Key = (), may_be_infinite: Iterable[str] = ()
) -> T:
    """Return `doc` as a `type_`.

    Raises InputError: `doc` does not fit the type.

    Parameters
    ----------
    doc
        The file, or a part of it, as tomllib or json parsed it.
    where, at
        The file and, for a part of it, the keys that lead there; only for errors.
    may_be_infinite
        Keys like `script.goal` under which nan and inf are allowed.
    """
    try:
        value = msgspec.convert(doc, type_)
    except msgspec.ValidationError as error:
        raise InputError(f"{where}: {_explain(str(error), doc, type_, at)}") from None
    allowed = tuple(may_be_infinite)
    for key, number in _not_finite(doc):
        if not _bare(at + key).startswith(allowed):
            raise InputError(
                f"{where}: {_dotted(at + key)} = {number}: expected a number that is finite"
            )
    return value


def nearest(name: str, known: Iterable[str], command: str = "") -> str:
    """Return a hint such as "; did you mean 'hall'?", or all names when none is near.

    With a `command` that lists them, it stands in place of names that would fill a screen.
    """
    names = sorted(known)
    close = difflib.get_close_matches(name, names, n=1, cutoff=NEAR)
    if close:
        return f"; did you mean '{close[0]}'?"
    if command and len(names) > MANY:
        return f"; `{command}` lists all {len(names)}"
    return f"; there is: {', '.join(names)}" if names else ""


def near_ones(name: str, known: Iterable[str]) -> list[str]:
    """Return the one name that must be meant, or those that have the word in them or are near."""
    names = sorted(known)
    if sure := difflib.get_close_matches(name, names, 1, SURE):
        return sure
    word = name.lower().strip("_")
    inside = [each for each in names if len(word) > 2 and word in each]
    return list(dict.fromkeys([*inside, *difflib.get_close_matches(name, names, FEW, NEAR)]))[:FEW]


def shown(value: Any) -> str:
    """Return a value as an error shows it: as in the file, shortened if it is long."""
    text = repr(value) if isinstance(value, float) else json.dumps(value, default=str)
    return text if len(text) <= _MAX_SHOWN else text[: _MAX_SHOWN - 1] + "…"


def _explain(error: str, doc: Any, type_: type, at: Key) -> str:
    match = _PATH.fullmatch(error)
    what, key = (match["what"], _keys(match["path"])) if match else (error, ())
    if unknown := _UNKNOWN.fullmatch(what):
        hint = nearest(unknown[1], _field_names(type_, key))
        return f"unknown key '{_dotted((*at, *key, unknown[1]))}'{hint}"
    if missing := _MISSING.fullmatch(what):
        return f"missing key '{_dotted((*at, *key, missing[1]))}'"
    came = _value_at(doc, key)
    if (ours := _OURS.fullmatch(what)) and isinstance(came, dict) and ours["key"] in came:
        key, what, came = (*key, ours["key"]), ours["what"], came[ours["key"]]
    expected = _expected(what, type_, key, came)
    value = "" if isinstance(came, dict) else f" = {shown(came)}"
    return f"{_dotted(at + key)}{value}: {expected}" if at + key else expected


def _expected(what: str, type_: type, key: Key, came: Any) -> str:
    if what.startswith("Invalid enum value"):
        return f"expected one of {', '.join(map(str, _type_at(type_, key).values))}"
    if (length := _LENGTH.match(what)) and isinstance(came, list):
        want = length["want"].replace("<= ", "at most ").replace(">= ", "at least ")
        return f"expected a list of {want} values, got {len(came)}"
    if bound := _BOUND.fullmatch(what):
        return f"expected {_WORDS[bound['type']]} {_bounds(_type_at(type_, key))}"
    if not what.startswith("Expected"):
        return what[:1].lower() + what[1:]  # from a __post_init__ of ours, or a number too large
    words = re.sub(r"`([^`]*)`", lambda m: _words(m[1]), what.removeprefix("Expected "))
    return f"expected {words}"


def _bounds(number: Any) -> str:
    """Return all bounds of a number's type, not only the one that was broken."""
    signs = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
    limits = {sign: getattr(number, name) for name, sign in signs.items()}
    return " and ".join(f"{sign} {limit}" for sign, limit in limits.items() if limit is not None)


def _words(names: str) -> str:
    return " or ".join(_WORDS.get(n, n) for n in names.split(" | ") if n != "null")


def _keys(path: str) -> Key:
    """Split msgspec's `$.boxes[1].size` into ("boxes", 1, "size")."""
    parts = re.findall(r"\.([^.\[]+)|\[(\d+)\]", path)
    return tuple(name or int(index) for name, index in parts)


def _dotted(key: Key) -> str:
    text = "".join(f"[{k}]" if isinstance(k, int) else f".{k}" for k in key)
    return text.removeprefix(".")


def _bare(key: Key) -> str:
    return ".".join(k for k in key if isinstance(k, str))


def _value_at(doc: Any, key: Key) -> Any:
    for part in key:
        doc = doc[part]
    return doc


def _type_at(type_: type, key: Key) -> Any:
    """Return msgspec's description of the type at these keys."""
    found: Any = msgspec.inspect.type_info(type_)
    for part in key:
        found = _without_none(found)
        if isinstance(part, str):
            found = next(f.type for f in found.fields if f.encode_name == part)
        else:
            found = found.item_types[part] if hasattr(found, "item_types") else found.item_type
    return _without_none(found)


def _without_none(found: Any) -> Any:
    if isinstance(found, msgspec.inspect.UnionType):
        return next(t for t in found.types if not isinstance(t, msgspec.inspect.NoneType))
    return found


def _field_names(type_: type, key: Key) -> list[str]:
    return [f.encode_name for f in _type_at(type_, key).fields]


def _not_finite(doc: Any, key: Key = ()) -> Iterator[tuple[Key, float]]:
    if isinstance(doc, float) and not math.isfinite(doc):
        yield key, doc
    elif isinstance(doc, dict):
        for name, value in doc.items():
            yield from _not_finite(value, (*key, name))
    elif isinstance(doc, list | tuple):
        for index, value in enumerate(doc):
            yield from _not_finite(value, (*key, index))


def unknown_name(what: str, name: str, known: Collection[str], listed: str) -> InputError:
    """Return the error for a name that nothing is called: the nearest ones have a line each.

    `listed` is the command that lists them all.
    """
    said, near = f"no {what} is called '{name}'", near_ones(name, known)
    if len(near) < 2:
        return InputError(said + nearest(name, near or known, listed))
    return InputError(f"{said}; `{listed}` lists all {len(known)}, and the nearest are", near)
