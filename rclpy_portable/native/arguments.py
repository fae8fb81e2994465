"""What a command line says after `--ros-args`: parameters, remappings, log levels."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from . import values
from .errors import RCLError, UnknownROSArgsError

SWITCHES = re.compile(r"--(enable|disable)-(rosout|stdout|external-lib)-logs")
WITH_VALUE = {"--log-config-file", "--log-file-name"}  # no effect here
NODE_NAMES = ("__node", "__name")
TOPIC, SERVICE, ACTION = "rostopic", "rosservice", "rosaction"  # schemes of names
TOKEN = r"[A-Za-z_](?:(?<!_)_|[A-Za-z0-9])*"
NAME = rf"(?:~?/)?{TOKEN}(?:/{TOKEN})*"
NODE = rf"(?:(?P<node>{TOKEN}):)?"
# What rcl's lexer knows (rcl/src/rcl/lexer.c); more is refused, as there
REMAPPING = re.compile(
    rf"{NODE}(?:(?P<scheme>{TOPIC}|{SERVICE})://)?(?P<before>{NAME}):=(?P<after>{NAME})"
)
RENAMING = re.compile(rf"{NODE}(?P<before>__node|__name):=(?P<after>{TOKEN})")
MOVING = re.compile(rf"{NODE}(?P<before>__ns):=(?P<after>/|(?:/{TOKEN})+)")
OVERRIDE = re.compile(
    rf"{NODE}(?P<name>(?!__)[A-Za-z_/][A-Za-z0-9_/]*(?:\.[A-Za-z_/][A-Za-z0-9_/]*)*):=(?P<value>.*)",
    re.DOTALL,
)
LOG_LEVEL = re.compile(r"(?:(?P<name>(?:(?!:=).)+):=)?(?P<level>\w+)")
LEVELS = {"unset": 0, "debug": 10, "info": 20, "warn": 30, "error": 40, "fatal": 50}


class Rule(NamedTuple):
    """A remapping."""

    node: str  # of which node; "": of all
    before: str
    after: str
    scheme: str = ""  # TOPIC or SERVICE; "": for all


class Override(NamedTuple):
    """A parameter's value."""

    node: str  # pattern of full names
    name: str
    value: Any  # None: not set


@dataclass
class Arguments:
    """What one command line says."""

    parameters: list[Override] = field(default_factory=list)
    rules: list[Rule] = field(default_factory=list)
    levels: dict[str, int] = field(default_factory=dict)  # by logger; "" for all
    stderr: bool = True  # log to the console

    def of_node(self, full_name: str) -> dict[str, Any]:
        """Return the parameters of a node: name and value."""
        said: dict[str, dict[str, list[Any]]] = {}  # by pattern, in the order of their first use
        for override in self.parameters:
            said.setdefault(override.node, {}).setdefault(override.name, []).append(override.value)
        return {
            name: values.chosen(given)
            for pattern, parameters in said.items()
            if _is_for(pattern, full_name)
            for name, given in parameters.items()
        }


def parse(words: Sequence[str]) -> Arguments:
    """Read a command line.

    Raises RCLError: something is not of the form that it should have.
    Raises UnknownROSArgsError: nobody knows what something after `--ros-args` means.
    """
    for word in words:
        word.encode()  # what is no text raises UnicodeEncodeError
    found, unknown, rest = Arguments(), [], iter(_ros_words(words))
    for word in rest:
        if word in ("-p", "--param"):
            found.parameters += _overrides(_value(rest, word, "parameter override rule found"))
        elif word in ("-r", "--remap"):
            found.rules.append(_rule(_value(rest, word, "remap rule found")))
        elif word == "--params-file":
            found.parameters += _from_file(_value(rest, word, "file path provided"))
        elif word == "--log-level":
            name, level = _level(_value(rest, word, "log level found"))
            found.levels[name] = level
        elif word in ("-e", "--enclave"):
            _check_enclave(_value(rest, word, "enclave path provided"))
        elif word in WITH_VALUE:
            _value(rest, word, "value found")
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
        raise _refusal(f"Couldn't parse trailing {flag} flag. No {what}.")
    return f"{flag} {value}"


def _refusal(text: str) -> RCLError:
    return RCLError(f"failed to initialize rcl: {text}")


def _overrides(said: str) -> list[Override]:
    match = OVERRIDE.fullmatch(said.partition(" ")[2])
    if not match:
        raise _refusal(f"Couldn't parse parameter override rule: '{said}'")
    try:
        given = values.of_option(match["value"])
    except (ValueError, yaml.YAMLError) as error:
        text = f"Couldn't parse parameter override rule: '{said}'. Error: {_problem(error)}"
        raise _refusal(text) from None
    return [Override(match["node"] or "/**", match["name"], value) for value in given]


def _rule(said: str) -> Rule:
    _, _, text = said.partition(" ")
    match = RENAMING.fullmatch(text) or MOVING.fullmatch(text) or REMAPPING.fullmatch(text)
    if not match:
        raise _refusal(f"Couldn't parse remap rule: '{said}'")
    parts = match.groupdict()
    return Rule(parts["node"] or "", parts["before"], parts["after"], parts.get("scheme") or "")


def _level(said: str) -> tuple[str, int]:
    match = LOG_LEVEL.fullmatch(said.partition(" ")[2])
    if not match or match["level"].lower() not in LEVELS:
        problem = "Argument does not use a valid severity level"
        raise _refusal(f"Couldn't parse log level: '{said}'. Error: {problem}")
    return match["name"] or "", LEVELS[match["level"].lower()]


def _check_enclave(said: str) -> None:
    _, _, path = said.partition(" ")
    if not path.startswith("/"):
        problem = "context name must be absolute, it must lead with a '/'"
        raise _refusal(f"Enclave name is not valid: '{problem}'. Invalid index: 0")


def _from_file(said: str) -> list[Override]:
    _, _, path = said.partition(" ")
    try:
        return [Override(*found) for found in values.of_file(Path(path))]
    except OSError:
        problem = "Error opening YAML file"
        raise _refusal(f"Couldn't parse params file: '{said}'. Error: {problem}") from None
    except (ValueError, yaml.YAMLError) as error:
        text = f"Couldn't parse params file: '{said}'. Error: {_problem(error)}"
        raise _refusal(text) from None


def _problem(error: Exception) -> str:
    return " ".join(str(error).split())


def _is_for(pattern: str, full_name: str) -> bool:
    """Return whether a pattern of rcl's means a node: `*` is one token, `**` any number."""
    if not pattern.startswith("/"):
        pattern = f"/{pattern}"
    form = re.escape(pattern).replace(r"/\*\*", r"(/\w+)*").replace(r"/\*", r"(/\w+)")
    return re.fullmatch(form, full_name) is not None
