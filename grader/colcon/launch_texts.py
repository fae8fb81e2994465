"""What is known while a launch file is carried out, and the texts that it makes of it.

Small stand-ins of the substitutions, conditions and parameters of `launch` and `launch_ros`; those
of their actions are in `launch_stand_in`.

Source: ros2/launch and ros2/launch_ros, branch jazzy.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

YES, NO = ("true", "1"), ("false", "0")  # what a condition may say


class Unknown(Exception):
    """A launch file has something that this stand-in does not know: a person has to look."""


class Mistaken(Exception):
    """A launch file has something that `ros2 launch` does not take either."""


@dataclass
class Started:
    """A node that a launch file starts."""

    package: str
    executable: str
    arguments: tuple[str, ...]
    needed: bool = False  # the others end with it
    made: dict[str, str] = field(default_factory=dict)  # parameter files


@dataclass
class Context:
    """What is known while a launch file is read."""

    package: str
    packages: frozenset[str]
    values: dict[str, str] = field(default_factory=dict)  # of its arguments
    namespace: str = ""
    parameters: tuple[tuple[str, str], ...] = ()  # of all nodes to come
    remappings: tuple[tuple[str, str], ...] = ()  # of these, too
    file: str = ""  # that is being read
    started: list[Started] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    made: int = 0  # parameter files
    depth: int = 0

    @property
    def launch_configurations(self) -> dict[str, str]:
        """The arguments' values, for functions of the launch file."""
        return self.values

    def perform_substitution(self, given: Any) -> str:
        """Return a text, for functions of the launch file."""
        return text_of(given, self)


class Substitution:
    """A text that is known only when the launch file is carried out."""

    def perform(self, context: Context) -> str:
        """Return the text."""
        raise NotImplementedError


class LaunchConfiguration(Substitution):
    """The value of an argument."""

    def __init__(self, variable_name: Any, *, default: Any = None) -> None:
        self._name, self._default = variable_name, default

    def perform(self, context: Context) -> str:
        """Return it, or the default."""
        name = text_of(self._name, context)
        if name in context.values:
            return context.values[name]
        if self._default is None:
            raise Mistaken(f"launch configuration '{name}' does not exist: declare the argument")
        return text_of(self._default, context)


class TextSubstitution(Substitution):
    """A text."""

    def __init__(self, *, text: str) -> None:
        self._text = text

    def perform(self, context: Context) -> str:
        """Return it."""
        return self._text


class PathJoinSubstitution(Substitution):
    """Parts of a path."""

    def __init__(self, substitutions: Iterable[Any]) -> None:
        self._parts = list(substitutions)

    def perform(self, context: Context) -> str:
        """Return the path."""
        return os.path.join(*(text_of(part, context) for part in self._parts))


class FindPackageShare(Substitution):
    """A package's share folder."""

    def __init__(self, package: Any) -> None:
        self._package = package

    def perform(self, context: Context) -> str:
        """Return the folder."""
        from ament_index_python import packages  # noqa: PLC0415  (comes with ROS)

        return str(packages.get_package_share_directory(text_of(self._package, context)))


class ThisLaunchFileDir(Substitution):
    """The folder of the launch file that has it."""

    def perform(self, context: Context) -> str:
        """Return it."""
        return str(Path(context.file).absolute().parent)


class IfCondition:
    """Whether something of a launch file happens."""

    wanted = True

    def __init__(self, predicate_expression: Any) -> None:
        self._expression = predicate_expression

    def holds(self, context: Context) -> bool:
        """Return whether it does."""
        said = text_of(self._expression, context).strip().lower()
        if said not in (*YES, *NO):
            raise Mistaken(f"a condition of the launch file says {said!r}; expected true or false")
        return (said in YES) == self.wanted


class UnlessCondition(IfCondition):
    """Whether it does not."""

    wanted = False


class ParameterValue:
    """A parameter's value, and the type that a text becomes."""

    def __init__(self, value: Any, *, value_type: Any = None) -> None:
        self._value, self._type = value, value_type

    def text(self, context: Context) -> str:
        """Return it as YAML."""
        if not _is_text(self._value) or self._type not in (str, int, float):
            return value_of(self._value, context)
        return json.dumps(self._type(text_of(self._value, context)))


class ParameterFile(Substitution):
    """A YAML file of parameters."""

    def __init__(self, param_file: Any, *, allow_substs: Any = False) -> None:
        self._file, self._substs = param_file, allow_substs

    def perform(self, context: Context) -> str:
        """Return its path."""
        path = text_of(self._file, context)
        if self._substs and Path(path).is_file() and b"$(" in Path(path).read_bytes():
            raise Unknown("ParameterFile(allow_substs=True): its $(…) are not read here")
        return path


def text_of(value: Any, context: Context) -> str:
    """Return the text of a text, a number, a path, a substitution, or a list of them.

    Raises Mistaken: it is none.
    """
    if isinstance(value, Substitution):
        return value.perform(context)
    if isinstance(value, list | tuple):
        return "".join(text_of(part, context) for part in value)
    if isinstance(value, str | os.PathLike | int | float):
        return os.fspath(value) if isinstance(value, os.PathLike) else str(value)
    raise Mistaken(f"a launch file has a {type(value).__name__} where a text belongs")


def value_of(value: Any, context: Context) -> str:
    """Return a parameter's value as YAML; raises as `text_of`."""
    if isinstance(value, ParameterValue):
        return value.text(context)
    if _is_text(value):
        return text_of(value, context) or '""'
    return json.dumps(value)  # YAML reads what JSON writes


def _is_text(value: Any) -> bool:
    """Return whether a parameter's value is a text that is known only now."""
    parts = value if isinstance(value, list | tuple) else [value]
    return any(isinstance(part, Substitution) for part in parts)


def flat(given: Mapping[Any, Any], context: Context) -> Iterator[tuple[str, str]]:
    """Yield parameters with dotted names, and their values as the command line has them."""
    for key, value in given.items():
        name = text_of(key, context)
        if isinstance(value, Mapping):
            yield from ((f"{name}.{inner}", text) for inner, text in flat(value, context))
        else:
            yield name, value_of(value, context)
