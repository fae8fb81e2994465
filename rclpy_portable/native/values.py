"""Values of parameters in YAML, read as rcl reads them: event by event, and YAML 1.1.

rcl keeps one value of each type for a parameter, and rclpy takes the first of them in an order of
its own: after `-p a:=1 -p a:=2.5` the parameter is 1. What has no value, such as `[]`, is "not
set".
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from .names import node_name_problem

TRUE = {"y", "Y", "yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON"}
FALSE = {"n", "N", "no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF"}
SPECIAL = {".nan": "nan", ".inf": "inf", "+.inf": "inf", "-.inf": "-inf"}
INTEGER = re.compile(r"([-+]?)(0[xX][0-9a-fA-F]+|0[0-7]*|[1-9][0-9]*)")  # as strtoll reads it
DECIMAL = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")  # as strtod reads it
HEXADECIMAL = re.compile(r"[-+]?0[xX]([0-9a-fA-F]+\.?[0-9a-fA-F]*)([pP][-+]?[0-9]+)?")
NO_NUMBER = re.compile(r"[-+]?(inf|infinity|nan)", re.IGNORECASE)
TEXT = "tag:yaml.org,2002:str"
QUOTED = ("'", '"')
NOT_SET = None
PRECEDENCE = (bool, int, float, str, (bool,), (int,), (float,), (str,))  # rclpy's, of types


class _Loader(yaml.SafeLoader):  # type: ignore[misc]
    """Tells a scalar whose type is not said from one that is said to be text."""

    yaml_implicit_resolvers = {None: [("plain", re.compile(""))]}  # noqa: RUF012


def of_option(text: str) -> list[Any]:
    """Return the values, one after the other, that `-p name:=text` gives to a parameter.

    Raises ValueError, yaml.YAMLError: it is none.
    """
    if not text:
        raise ValueError("error not set")
    node = yaml.compose(text, _Loader)
    return [NOT_SET] if node is None else _stored(node)


def of_file(path: Path) -> Iterator[tuple[str, str, Any]]:
    """Find what a file of parameters says: pattern of a node's name, parameter, value.

    Raises OSError: it can't be read.
    Raises ValueError, yaml.YAMLError: it is no file of parameters.
    """
    text = path.read_text("utf-8")
    if any(isinstance(event, yaml.AliasEvent) for event in yaml.parse(text, _Loader)):
        raise ValueError("Will not support aliasing")
    for root in yaml.compose_all(text, _Loader):
        if root is not None:
            yield from _nodes(root, "")


def chosen(values: list[Any]) -> Any:
    """Return the value that a parameter has after these, one after the other."""
    last = {_kind(value): value for value in values if value is not NOT_SET}
    return next((last[kind] for kind in PRECEDENCE if kind in last), NOT_SET)


def _kind(value: Any) -> Any:
    return (type(value[0]),) if isinstance(value, list) else type(value)


def _nodes(tree: Any, prefix: str) -> Iterator[tuple[str, str, Any]]:
    """Find the parameters of nodes; names of nodes may stand below namespaces."""
    if not isinstance(tree, yaml.MappingNode):
        raise ValueError("Cannot have a value before ros__parameters")
    for i, (key, value) in enumerate(tree.value):
        if key.value == "ros__parameters":
            _check_pattern(prefix)
            for parameter, content in _flat(value, ""):
                yield prefix, parameter, content
            if i + 1 < len(tree.value):
                raise ValueError("expected nothing after ros__parameters")
        else:
            yield from _nodes(value, f"{prefix}/{key.value}" if prefix else key.value)


def _check_pattern(pattern: str) -> None:
    if not pattern:
        raise ValueError("There are no node names before ros__parameters")
    for token in pattern.removeprefix("/").split("/"):
        problem = None if token in ("*", "**") else node_name_problem(token)
        if problem:
            raise ValueError(problem[0])


def _flat(tree: Any, prefix: str) -> Iterator[tuple[str, Any]]:
    if not isinstance(tree, yaml.MappingNode):
        raise ValueError("Cannot have a value before ros__parameters")
    for key, value in tree.value:
        if not key.value:
            raise ValueError("No key")
        name = f"{prefix}{key.value}"
        if isinstance(value, yaml.MappingNode) and value.value:
            yield from _flat(value, f"{name}.")
        elif isinstance(value, yaml.MappingNode):
            yield name, NOT_SET
        elif isinstance(value, yaml.ScalarNode) and not value.value and value.style is None:
            raise ValueError("No value")
        else:
            yield from ((name, content) for content in _stored(value))


def _stored(node: Any) -> list[Any]:
    """Return the values that rcl stores while it reads: a list within a list ends the outer one."""
    if isinstance(node, yaml.ScalarNode):
        return [_scalar(node)]
    if not isinstance(node, yaml.SequenceNode):
        raise ValueError("Unknown YAML event")
    found: list[Any] = []
    entries: list[Any] = []
    inside = True
    for entry in node.value:
        if isinstance(entry, yaml.SequenceNode):
            found += ([entries] if entries else []) + [v for v in _stored(entry) if v is not None]
            entries, inside = [], False
        elif not inside:
            found += _stored(entry)
        else:
            entries += _stored(entry)
            if type(entries[-1]) is not type(entries[0]):
                raise ValueError("Sequence should be of same type")
    return [*found, *([entries] if entries else [])] or [NOT_SET]


def _scalar(node: Any) -> Any:
    if node.style in QUOTED or (node.tag == TEXT and not node.style):
        return node.value
    return _plain(node.value)


def _plain(text: str) -> Any:
    if text in TRUE or text in FALSE:
        return text in TRUE
    if text.lower() in SPECIAL:
        return float(SPECIAL[text.lower()])
    if match := INTEGER.fullmatch(text):
        digits = match[2]
        octal = digits.startswith("0") and digits[1:].isdigit()
        number = int(f"{match[1]}{digits}", 8 if octal else 0)
        if -(2**63) <= number < 2**63:
            return number
    if DECIMAL.fullmatch(text):
        value = float(text)
        in_range = abs(value) < float("inf") and (value or not re.match(r"[-+.0]*[1-9]", text))
        return value if in_range else text
    if HEXADECIMAL.fullmatch(text):
        return float.fromhex(text)
    return float(text) if NO_NUMBER.fullmatch(text) else text
