"""Read a launch file, with a small stand-in of `launch` and `launch_ros`.

PyPI has no wheels of them. A launch file is a program: it runs here, behind the wall. What it
starts comes out as command lines; what the stand-in does not know is named in one line.

Source: ros2/launch and ros2/launch_ros, branch jazzy.
"""

from __future__ import annotations

import contextlib
import json
import os
import runpy
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

KNOWN = (
    "Node, DeclareLaunchArgument, LaunchConfiguration, IncludeLaunchDescription, "
    "PythonLaunchDescriptionSource, PathJoinSubstitution, FindPackageShare"
)
WITHOUT_EFFECT = {"output", "emulate_tty", "exec_name", "sigterm_timeout", "sigkill_timeout"}
MAX_DEPTH = 8  # of launch files that include one another


class Unknown(Exception):
    """A launch file has something that this stand-in does not know, or is wrong."""


@dataclass
class Started:
    """A node that a launch file starts."""

    executable: str
    arguments: tuple[str, ...]


@dataclass
class Context:
    """What is known while a launch file is read."""

    package: str
    values: dict[str, str] = field(default_factory=dict)  # of its arguments
    started: list[Started] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    depth: int = 0


def read(file: str, package: str) -> tuple[list[Started], list[str]]:
    """Return what a launch file of a package starts, and what is left out.

    Raises
    ------
    Unknown
        It has something that is not known here.
    """
    here = Path.cwd()
    paths = (str(here), os.environ.get("AMENT_PREFIX_PATH", ""))
    os.environ["AMENT_PREFIX_PATH"] = os.pathsep.join(filter(None, paths))
    context = Context(package)
    with standing_in(_modules()):
        _include(file, context)
    if not context.started:
        raise Unknown(f"{file} starts no node of the package {package}")
    for each in context.started:  # the package lies elsewhere when the nodes run
        each.arguments = tuple(word.replace(f"{here}/", "") for word in each.arguments)
    return context.started, context.notes


@contextlib.contextmanager
def standing_in(modules: Mapping[str, Any]) -> Iterator[None]:
    """Let these modules be imported in place of others of the same names."""
    before = {name: sys.modules.get(name) for name in modules}
    sys.modules.update(modules)
    try:
        yield
    finally:
        for name, module in before.items():
            sys.modules.pop(name, None)
            if module is not None:
                sys.modules[name] = module


def _include(file: str, context: Context) -> None:
    if context.depth == MAX_DEPTH:
        raise Unknown(f"{file}: launch files that include one another without end")
    context.depth += 1
    if not file.endswith(".py"):
        raise Unknown(f"{file}: only launch files in Python are read here, not XML or YAML")
    made = runpy.run_path(file).get("generate_launch_description")
    if made is None:
        raise Unknown(f"{file}: expected a function generate_launch_description")
    _visit(made(), context)
    context.depth -= 1


def _visit(entity: Any, context: Context) -> None:
    if isinstance(entity, LaunchDescription):
        for each in entity.entities:
            _visit(each, context)
    elif isinstance(entity, _Action):
        entity.act(context)
    else:
        raise Unknown(f"a launch file has a {type(entity).__name__}; known here are {KNOWN}")


# --- what launch files are made of ---------------------------------------------------------------


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
        name = _text(self._name, context)
        if name in context.values:
            return context.values[name]
        if self._default is None:
            raise Unknown(f"launch configuration '{name}' does not exist: declare the argument")
        return _text(self._default, context)


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
        return os.path.join(*(_text(part, context) for part in self._parts))


class FindPackageShare(Substitution):
    """A package's share folder."""

    def __init__(self, package: Any) -> None:
        self._package = package

    def perform(self, context: Context) -> str:
        """Return the folder."""
        from ament_index_python import packages  # noqa: PLC0415  (comes with ROS)

        return str(packages.get_package_share_directory(_text(self._package, context)))


class LaunchDescription:
    """What a launch file returns."""

    def __init__(self, initial_entities: Iterable[Any] | None = None) -> None:
        self.entities = list(initial_entities or ())

    def add_action(self, action: Any) -> None:
        """Add one more."""
        self.entities.append(action)

    add_entity = add_action


class _Action:
    def act(self, context: Context) -> None:
        raise NotImplementedError


class DeclareLaunchArgument(_Action):
    """An argument of the launch file, which has its default here."""

    def __init__(
        self, name: str, *, default_value: Any = None, description: Any = "", choices: Any = None
    ) -> None:
        self._name, self._default, self._choices = name, default_value, choices

    def act(self, context: Context) -> None:
        """Let it have its default, unless who includes the file gives a value."""
        if self._name not in context.values:
            if self._default is None:
                raise Unknown(f"the launch argument {self._name} needs a default here")
            context.values[self._name] = _text(self._default, context)
        value = context.values[self._name]
        if self._choices is not None and value not in self._choices:
            raise Unknown(f"{self._name}:={value}: expected one of {', '.join(self._choices)}")


class PythonLaunchDescriptionSource:
    """The path of another launch file."""

    def __init__(self, launch_file_path: Any) -> None:
        self.path = launch_file_path


class IncludeLaunchDescription(_Action):
    """Another launch file."""

    def __init__(self, launch_description_source: Any, *, launch_arguments: Any = ()) -> None:
        self._source, self._arguments = launch_description_source, launch_arguments

    def act(self, context: Context) -> None:
        """Carry it out with its arguments."""
        given = self._arguments.items() if isinstance(self._arguments, Mapping) else self._arguments
        for name, value in given or ():
            context.values[_text(name, context)] = _text(value, context)
        _include(_text(getattr(self._source, "path", self._source), context), context)


class Node(_Action):
    """A program of a package."""

    def __init__(
        self, *, package: Any = None, executable: Any, name: Any = None, namespace: Any = None,
        parameters: Any = None, remappings: Any = None, arguments: Any = None,
        ros_arguments: Any = None, **more: Any,
    ) -> None:  # fmt: skip
        if odd := [key for key, value in more.items() if value and key not in WITHOUT_EFFECT]:
            raise Unknown(f"Node({odd[0]}=…) is not known here; leave it out")
        self._package, self._executable = package, executable
        self._name, self._namespace = name, namespace
        if isinstance(parameters, str | Mapping | Substitution):  # launch_ros takes a list, too
            raise Unknown("Node(parameters=…) takes a list: put square brackets around it")
        self._parameters, self._remappings = parameters or (), remappings or ()
        self._arguments, self._ros_arguments = arguments or (), ros_arguments or ()

    def act(self, context: Context) -> None:
        """Note its command line; another package's node is left out."""
        package = _text(self._package, context) if self._package else context.package
        executable = _text(self._executable, context)
        if package != context.package:
            context.notes.append(f"{executable} of the package {package} is not started here")
            return
        words = [_text(word, context) for word in self._ros_arguments]
        if self._name is not None:
            words += ["-r", f"__node:={_text(self._name, context)}"]
        if self._namespace is not None:
            words += ["-r", f"__ns:=/{_text(self._namespace, context).removeprefix('/')}"]
        for source, target in self._remappings:
            words += ["-r", f"{_text(source, context)}:={_text(target, context)}"]
        for given in self._parameters:
            if isinstance(given, Mapping):
                for name, value in _flat(given, context):
                    words += ["-p", f"{name}:={value}"]
            else:
                words += ["--params-file", _text(given, context)]
        own = [_text(word, context) for word in self._arguments]
        ros = ["--ros-args", *words, "--"] if words else []
        context.started.append(Started(executable, (*ros, *own)))


def _flat(given: Mapping[Any, Any], context: Context) -> Iterator[tuple[str, str]]:
    """Yield parameters with dotted names, and their values as the command line has them."""
    for key, value in given.items():
        name = _text(key, context)
        if isinstance(value, Mapping):
            yield from ((f"{name}.{inner}", text) for inner, text in _flat(value, context))
        else:
            yield name, _value(value, context)


def _value(value: Any, context: Context) -> str:
    if isinstance(value, Substitution):
        value = [value]
    if isinstance(value, list | tuple) and any(isinstance(part, Substitution) for part in value):
        return _text(value, context) or '""'
    return json.dumps(value)  # YAML reads what JSON writes


def _text(value: Any, context: Context) -> str:
    if isinstance(value, Substitution):
        return value.perform(context)
    if isinstance(value, list | tuple):
        return "".join(_text(part, context) for part in value)
    if isinstance(value, str | os.PathLike | int | float):
        return os.fspath(value) if isinstance(value, os.PathLike) else str(value)
    raise Unknown(f"a launch file has a {type(value).__name__} where a text belongs")


def _modules() -> dict[str, ModuleType]:
    """Return the stand-ins, by the names that launch files import them by."""
    has: dict[str, tuple[type, ...]] = {
        "launch": (LaunchDescription, Substitution),
        "launch.actions": (DeclareLaunchArgument, IncludeLaunchDescription),
        "launch.conditions": (),
        "launch.event_handlers": (),
        "launch.launch_description_sources": (PythonLaunchDescriptionSource,),
        "launch.substitutions": (LaunchConfiguration, PathJoinSubstitution, TextSubstitution),
        "launch_ros": (),
        "launch_ros.actions": (Node,),
        "launch_ros.descriptions": (),
        "launch_ros.parameter_descriptions": (),
        "launch_ros.substitutions": (FindPackageShare,),
    }
    made = {name: _module(name, {each.__name__: each for each in own}) for name, own in has.items()}
    for name, module in made.items():
        parent, _, last = name.rpartition(".")
        if parent:
            setattr(made[parent], last, module)
    return made


def _module(name: str, has: Mapping[str, Any]) -> ModuleType:
    """Return a module that says what it lacks."""
    module: Any = ModuleType(name)
    module.__dict__.update(has)
    module.__path__ = []

    def lacks(wanted: str) -> Any:
        if wanted.startswith("__"):
            raise AttributeError(wanted)
        raise Unknown(f"{name}.{wanted} is not known here; a launch file may have {KNOWN}")

    module.__getattr__ = lacks
    found: ModuleType = module
    return found
