"""What a command line says after `--ros-args`: parameters, remappings, log levels."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from .errors import RCLError, UnknownROSArgsError

SWITCHES = re.compile(r"--(enable|disable)-(rosout|stdout|external-lib)-logs")
WITH_VALUE = {"-e", "--enclave", "--log-config-file", "--log-file-name"}  # no effect here
NODE_NAMES = ("__node", "__name")
NAME = re.compile(r"[A-Za-z_~/{][\w.~/{}*-]*")
TRUE = {"y", "Y", "yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON"}
FALSE = {"n", "N", "no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF"}
SPECIAL = {".nan": "nan", ".inf": "inf", "+.inf": "inf", "-.inf": "-inf"}
LEVELS = {"unset": 0, "debug": 10, "info": 20, "warn": 30, "error": 40, "fatal": 50}


class Rule(NamedTuple):
    """A remapping."""

    node: str  # of which node; "": of all
    before: str
    after: str


class Override(NamedTuple):
    """A parameter's value."""

    node: str  # pattern of full names
    name: str
    value: Any


@dataclass
class Arguments:
    """What one command line says."""

    parameters: list[Override] = field(default_factory=list)
    rules: list[Rule] = field(default_factory=list)
    levels: dict[str, int] = field(default_factory=dict)  # by logger; "" for all
    stderr: bool = True  # log to the console

    def of_node(self, full_name: str) -> dict[str, Any]:
        """Return the parameters of a node: name and value."""
        return {o.name: o.value for o in self.parameters if _is_for(o.node, full_name)}


def parse(words: Sequence[str]) -> Arguments:
    """Read a command line.

    Raises
    ------
    RCLError
        Something is not of the form that it should have.
    UnknownROSArgsError
        Nobody knows what something after `--ros-args` means.
    """
    for word in words:
        word.encode()  # what is no text raises UnicodeEncodeError
    found, unknown, rest = Arguments(), [], iter(_ros_words(words))
    for word in rest:
        if word in ("-p", "--param"):
            found.parameters.append(_override(_value(rest, word, "parameter override rule")))
        elif word in ("-r", "--remap"):
            found.rules.append(_rule(_value(rest, word, "remap rule")))
        elif word == "--params-file":
            found.parameters += _from_file(_value(rest, word, "file path"))
        elif word == "--log-level":
            name, level = _level(_value(rest, word, "log level"))
            found.levels[name] = level
        elif word in WITH_VALUE:
            _value(rest, word, "value")
        elif match := SWITCHES.fullmatch(word):
            if match[2] == "stdout":
                found.stderr = match[1] == "enable"
        else:
            unknown.append(word)
    if unknown:
        raise UnknownROSArgsError(str(unknown))
    return found


def without_ros_arguments(words: Sequence[str]) -> list[str]:
    """Return what is not for ROS: rclpy_remove_ros_args."""
    kept, inside = [], False
    for word in words:
        if word == "--ros-args":
            inside = True
        elif inside and word == "--":
            inside = False
        elif not inside:
            kept.append(word)
    return kept


def _ros_words(words: Sequence[str]) -> Iterator[str]:
    inside = False
    for word in words:
        if word == "--ros-args":
            inside = True
        elif word == "--":
            inside = False
        elif inside:
            yield word


def _value(rest: Iterator[str], flag: str, what: str) -> str:
    value = next(rest, None)
    if value is None:
        raise _refusal(f"Couldn't parse trailing {flag} flag. No {what} found.")
    return f"{flag} {value}"


def _refusal(text: str) -> RCLError:
    return RCLError(f"failed to initialize rcl: {text}")


def _override(said: str) -> Override:
    _, _, text = said.partition(" ")
    name, separator, value = text.partition(":=")
    node, _, name = name.rpartition(":")
    if not separator or not NAME.fullmatch(name) or (node and not NAME.fullmatch(node)):
        raise _refusal(f"Couldn't parse parameter override rule: '{said}'")
    try:
        return Override(node or "/**", name, read_yaml(value))
    except (ValueError, yaml.YAMLError) as error:
        problem = " ".join(str(error).split())
        text = f"Couldn't parse parameter override rule: '{said}'. Error: {problem}"
        raise _refusal(text) from None


def _rule(said: str) -> Rule:
    _, _, text = said.partition(" ")
    before, separator, after = text.partition(":=")
    node, _, before = before.rpartition(":")
    if before.startswith("//"):  # rostopic://, rosservice://
        node, before = node.rpartition(":")[0], before[2:]
    if not separator or not NAME.fullmatch(before) or not NAME.fullmatch(after):
        raise _refusal(f"Couldn't parse remap rule: '{said}'")
    return Rule(node, before, after)


def _level(said: str) -> tuple[str, int]:
    _, _, text = said.partition(" ")
    name, _, level = text.rpartition(":=")
    if level.lower() not in LEVELS:
        problem = "Argument does not use a valid severity level"
        raise _refusal(f"Couldn't parse log level: '{said}'. Error: {problem}")
    return name, LEVELS[level.lower()]


def _from_file(said: str) -> Iterator[Override]:
    _, _, path = said.partition(" ")
    try:
        root = yaml.compose(Path(path).read_text("utf-8"), yaml.SafeLoader)
        yield from _nodes(root, "")
    except OSError:
        problem = "Error opening YAML file"
        raise _refusal(f"Couldn't parse params file: '{said}'. Error: {problem}") from None
    except (ValueError, yaml.YAMLError) as error:
        problem = " ".join(str(error).split())
        raise _refusal(f"Couldn't parse params file: '{said}'. Error: {problem}") from None


def _nodes(tree: Any, prefix: str) -> Iterator[Override]:
    """Find the parameters of nodes; names of nodes may stand below namespaces."""
    if not isinstance(tree, yaml.MappingNode):
        raise ValueError("expected names of nodes, and `ros__parameters` below each")
    for key, value in tree.value:
        name = key.value if not prefix else f"{prefix}/{key.value.lstrip('/')}"
        if key.value == "ros__parameters":
            for parameter, content in _flat(value, ""):
                yield Override(prefix, parameter, content)
        else:
            yield from _nodes(value, name)


def _flat(tree: Any, prefix: str) -> Iterator[tuple[str, Any]]:
    if not isinstance(tree, yaml.MappingNode):
        raise ValueError("expected names of parameters below `ros__parameters`")
    for key, value in tree.value:
        name = f"{prefix}{key.value}"
        if isinstance(value, yaml.MappingNode):
            yield from _flat(value, f"{name}.")
        else:
            yield name, _content(value)


def read_yaml(text: str) -> Any:
    """Return a parameter's value as rcl reads it: YAML 1.1, and arrays of one type.

    Raises
    ------
    ValueError, yaml.YAMLError
        It is none.
    """
    node = yaml.compose(text, yaml.SafeLoader)
    return "" if node is None else _content(node)


def _content(node: Any) -> Any:
    if isinstance(node, yaml.SequenceNode):
        values = [_content(entry) for entry in node.value]
        if len({type(value) for value in values}) > 1:
            raise ValueError("Sequence should be of same type")
        if any(isinstance(value, list) for value in values):
            raise ValueError("Sequences can only hold values")
        return values
    if not isinstance(node, yaml.ScalarNode):
        raise ValueError("expected a value, or an array of values")
    if node.style in ("'", '"') or (node.tag == "tag:yaml.org,2002:str" and node.style):
        return node.value
    return _plain(node.value)


def _plain(text: str) -> Any:
    if text in TRUE or text in FALSE:
        return text in TRUE
    if text.lower() in SPECIAL:
        return float(SPECIAL[text.lower()])
    try:
        octal = re.fullmatch(r"([-+]?)0([0-7]+)", text)  # as strtoll reads it
        number = int(f"{octal[1]}0o{octal[2]}", 8) if octal else int(text, 0)
        if "_" not in text and -(2**63) <= number < 2**63:
            return number
    except ValueError:
        pass
    if re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", text):
        return float(text)
    return text


def _is_for(pattern: str, full_name: str) -> bool:
    """Tell whether a pattern of rcl's means a node: `*` is one token, `**` any number."""
    if not pattern.startswith("/"):
        pattern = f"/{pattern}"
    form = re.escape(pattern).replace(r"/\*\*", r"(/\w+)*").replace(r"/\*", r"(/\w+)")
    return re.fullmatch(form, full_name) is not None
