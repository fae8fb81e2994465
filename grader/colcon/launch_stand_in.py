"""What launch files do: small stand-ins of the actions of `launch` and `launch_ros`.

They know how each acts in a `Context`; what they don't know they name. `launch_files` reads a file.

Source: ros2/launch and ros2/launch_ros, branch jazzy.
"""

from __future__ import annotations

import difflib
import functools
import json
import re
import runpy
import sys
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from grader.colcon.launch_texts import (
    Context,
    IfCondition,
    Mistaken,
    Started,
    Substitution,
    Unknown,
    flat,
    text_of,
)

KNOWN = (
    "Node, ParameterValue, ParameterFile, DeclareLaunchArgument, LaunchConfiguration, "
    "IncludeLaunchDescription, PythonLaunchDescriptionSource, PathJoinSubstitution, "
    "FindPackageShare, ThisLaunchFileDir, GroupAction, OpaqueFunction, TimerAction, "
    "PushRosNamespace, SetRemap, SetParameter, IfCondition, UnlessCondition, LogInfo"
)
# of Node: `respawn` of a node that doesn't die; what is none of these two is misspelt
WITHOUT_EFFECT = {
    "output", "output_format", "log_cmd", "cached_output", "emulate_tty", "exec_name",
    "sigterm_timeout", "sigkill_timeout", "respawn", "respawn_delay", "respawn_max_retries",
}  # fmt: skip
NODES_OWN = (
    "package", "executable", "name", "namespace", "parameters", "remappings", "arguments",
    "ros_arguments", "output", "respawn", "condition",
)  # fmt: skip
LEFT = {"shell", "prefix", "cwd", "env", "additional_env", "on_exit", "process_description"}
RCLPYS = "this Node is rclpy's; write `from launch_ros.actions import Node`"
RETURNS = "its last line has to be `return LaunchDescription([…])`"
FOREIGN = "/not/here/"  # where a package lies that is not here
MAX_DEPTH = 8  # of launch files that include one another
NO_NAME = re.compile(r"^$|\s|:=|[^/]/$")  # of a topic or service
NAMES = 'expected two names without blanks, as in ("scan", "/scan"): the program\'s, then the new'


def include(file: str, context: Context) -> None:
    """Carry out a launch file.

    Raises Unknown: it has something that is not known here.
    Raises Mistaken: it has something that is wrong.
    """
    if file.startswith(FOREIGN):
        package = file.removeprefix(FOREIGN).partition("/")[0]
        context.notes.append(f"{Path(file).name} of the package {package} is not started here")
        return
    if context.depth == MAX_DEPTH:
        raise Mistaken(f"{file}: launch files that include one another without end")
    context.depth += 1
    before, context.file = context.file, file
    if not file.endswith(".py"):
        raise Unknown(f"{file}: only launch files in Python are read here, not XML or YAML")
    made = runpy.run_path(file).get("generate_launch_description")
    if made is None:
        raise Mistaken(f"{file}: expected a function generate_launch_description")
    described = made()
    if not isinstance(described, LaunchDescription):
        what = "nothing" if described is None else f"a {type(described).__name__}"
        raise Mistaken(f"{file}: generate_launch_description returns {what}; {RETURNS}")
    visit(described, context)
    context.file = before
    context.depth -= 1


def visit(entity: Any, context: Context) -> None:
    """Do what an entity of a launch file says; raises as `include`."""
    if isinstance(entity, LaunchDescription):
        for each in entity.entities:
            visit(each, context)
    elif isinstance(entity, _Action):
        try:
            if entity.condition is None or entity.condition.holds(context):
                entity.act(context)
        except (Unknown, Mistaken) as error:
            if not hasattr(error, "where"):  # the innermost action is meant
                error.where = entity.where  # type: ignore[union-attr]
            raise
    else:
        has = f"a launch file has a {type(entity).__name__} where an action belongs"
        mine = RCLPYS if type(entity).__module__.startswith("rclpy") else "such as Node(…)"
        raise Mistaken(f"{has}: {mine}")


class LaunchDescription:
    """What a launch file returns."""

    def __init__(self, initial_entities: Iterable[Any] | None = None) -> None:
        self.entities = list(initial_entities or ())

    def add_action(self, action: Any) -> None:
        """Add one more."""
        self.entities.append(action)

    add_entity = add_action


class _Action:
    def __init__(self, *, condition: Any = None, **more: Any) -> None:
        self.where = _place()
        if odd := [key for key, value in more.items() if value and key not in WITHOUT_EFFECT]:
            near = difflib.get_close_matches(odd[0], NODES_OWN, 1)
            if isinstance(self, Node) and odd[0] not in LEFT:
                meant = f": is {near[0]} meant?" if near else ""
                raise Mistaken(f"Node has no argument {odd[0]}{meant}")
            raise Unknown(f"{type(self).__name__}({odd[0]}=…) is not known here")
        if condition is not None and not isinstance(condition, IfCondition):
            raise Unknown("condition=… takes IfCondition(…) or UnlessCondition(…) here")
        self.condition = condition

    def act(self, context: Context) -> None:
        raise NotImplementedError


class DeclareLaunchArgument(_Action):
    """An argument of the launch file, which has its default here."""

    def __init__(
        self,
        name: str,
        *,
        default_value: Any = None,
        description: Any = "",
        choices: Any = None,
        **more: Any,
    ) -> None:
        super().__init__(**more)
        self._name, self._default, self._choices = name, default_value, choices

    def act(self, context: Context) -> None:
        """Let it have its default, unless who includes the file gives a value."""
        if self._name not in context.values:
            if self._default is None:
                raise Mistaken(f"the launch argument {self._name!r} needs a default here")
            context.values[self._name] = text_of(self._default, context)
        value = context.values[self._name]
        if self._choices is not None and value not in self._choices:
            raise Mistaken(f"{self._name}:={value}: expected one of {', '.join(self._choices)}")


class PythonLaunchDescriptionSource:
    """The path of another launch file."""

    def __init__(self, launch_file_path: Any) -> None:
        self.path = launch_file_path


class IncludeLaunchDescription(_Action):
    """Another launch file."""

    def __init__(
        self, launch_description_source: Any, *, launch_arguments: Any = (), **more: Any
    ) -> None:
        super().__init__(**more)
        self._source, self._arguments = launch_description_source, launch_arguments

    def act(self, context: Context) -> None:
        """Carry it out with its arguments."""
        given = self._arguments.items() if isinstance(self._arguments, Mapping) else self._arguments
        for name, value in given or ():
            context.values[text_of(name, context)] = text_of(value, context)
        include(text_of(getattr(self._source, "path", self._source), context), context)


class GroupAction(_Action):
    """Some actions; what they set holds among them only."""

    def __init__(self, actions: Iterable[Any], *, scoped: bool = True, **more: Any) -> None:
        super().__init__(**more)
        self._actions, self._scoped = actions, scoped

    def act(self, context: Context) -> None:
        """Do them all."""
        before = replace(context, values=dict(context.values))
        for each in self._actions:
            visit(each, context)
        if self._scoped:
            context.values, context.namespace = before.values, before.namespace
            context.parameters, context.remappings = before.parameters, before.remappings


class OpaqueFunction(_Action):
    """A function of the launch file, which returns more of it."""

    def __init__(
        self, *, function: Any, args: Iterable[Any] = (), kwargs: Any = None, **more: Any
    ) -> None:
        super().__init__(**more)
        self._call = functools.partial(function, **(kwargs or {}))
        self._given = list(args or ())

    def act(self, context: Context) -> None:
        """Call it, and do what it says."""
        for each in self._call(context, *self._given) or ():
            visit(each, context)


class TimerAction(_Action):
    """Some actions, after a while."""

    def __init__(self, *, period: Any, actions: Iterable[Any], **more: Any) -> None:
        super().__init__(**more)
        self._period, self._actions = period, list(actions)

    def act(self, context: Context) -> None:
        """Do them at once."""
        after = text_of(self._period, context)
        context.notes.append(f"what starts after {after} s by TimerAction starts at once here")
        for each in self._actions:
            visit(each, context)


class PushROSNamespace(_Action):
    """A namespace for all nodes that follow."""

    def __init__(self, namespace: Any, **more: Any) -> None:
        super().__init__(**more)
        self._namespace = namespace

    def act(self, context: Context) -> None:
        """Put it below the present one."""
        context.namespace = _below(context.namespace, text_of(self._namespace, context))


class SetParameter(_Action):
    """A parameter of all nodes that follow."""

    def __init__(self, name: Any, value: Any, **more: Any) -> None:
        super().__init__(**more)
        self._given = {tuple(name) if isinstance(name, list) else name: value}

    def act(self, context: Context) -> None:
        """Note it."""
        context.parameters += tuple(flat(self._given, context))


class SetRemap(_Action):
    """A remapping of all nodes that follow; it goes before their own, as in launch_ros."""

    def __init__(self, src: Any, dst: Any, **more: Any) -> None:
        super().__init__(**more)
        self._pair = src, dst

    def act(self, context: Context) -> None:
        """Note it."""
        source, target = (text_of(each, context) for each in self._pair)
        context.remappings += ((source, target),)


class LogInfo(_Action):
    """A line for whoever starts it."""

    def __init__(self, *, msg: Any, **more: Any) -> None:
        super().__init__(**more)
        self._said = msg

    def act(self, context: Context) -> None:
        """Read it only."""
        text_of(self._said, context)


class Shutdown(_Action):
    """The end of all, for a node's `on_exit`."""

    def __init__(self, *, reason: Any = "", **more: Any) -> None:
        super().__init__(**more)

    def act(self, context: Context) -> None:
        """Refuse to end before anything has begun."""
        raise Unknown("Shutdown is known here only in Node(on_exit=Shutdown())")


class Node(_Action):
    """A program of a package."""

    def __init__(
        self, *, package: Any = None, executable: Any, name: Any = None, namespace: Any = None,
        parameters: Any = None, remappings: Any = None, arguments: Any = None,
        ros_arguments: Any = None, on_exit: Any = None, **more: Any,
    ) -> None:  # fmt: skip
        ends = on_exit if isinstance(on_exit, list) else [on_exit]
        self._needed = bool(ends) and all(isinstance(each, Shutdown) for each in ends)
        super().__init__(**more, on_exit=None if self._needed else on_exit)
        self._package, self._executable = package, executable
        self._name, self._namespace = name, namespace
        if isinstance(parameters, str | Mapping | Substitution):  # launch_ros takes a list, too
            raise Mistaken("Node(parameters=…) takes a list: put square brackets around it")
        pairs = remappings or ()
        if not all(isinstance(pair, list | tuple) and len(pair) == 2 for pair in pairs):
            raise Mistaken('Node(remappings=…) takes a list of pairs, as in [("scan", "/scan")]')
        self._parameters, self._remappings = parameters or (), remappings or ()
        self._arguments, self._ros_arguments = arguments or (), ros_arguments or ()

    def act(self, context: Context) -> None:
        """Note its command line; another package's node is left out."""
        package = text_of(self._package, context) if self._package else context.package
        executable = text_of(self._executable, context)
        if not package:
            raise Unknown(f"Node(executable={executable!r}): name its package, too")
        if package not in context.packages:
            context.notes.append(f"{executable} of the package {package} is not started here")
            return
        name = text_of(self._name, context) if self._name is not None else ""
        namespace = context.namespace
        if self._namespace is not None:
            namespace = _below(namespace, text_of(self._namespace, context)) or "/"
        made: dict[str, str] = {}
        node = f"{namespace.rstrip('/')}/{name}" if name and namespace else ""
        words = [text_of(word, context) for word in self._ros_arguments]
        words += ["-r", f"__node:={name}"] if name else []
        words += ["-r", f"__ns:={namespace}"] if namespace else []
        for parameter, value in context.parameters:
            words += ["-p", f"{parameter}:={value}"]
        for given in self._parameters:
            if not isinstance(given, Mapping):
                words += ["--params-file", text_of(given, context)]
            elif node and given:  # as in launch_ros, so that it goes before a file's lines for it
                context.made += 1
                words += ["--params-file", file := f"launch_params_{context.made}.yaml"]
                made[file] = _yaml(node, flat(given, context))
            else:
                words += [w for pair in flat(given, context) for w in ("-p", ":=".join(pair))]
        for pair in (*context.remappings, *self._remappings):
            names = tuple(text_of(name, context) for name in pair)
            if any(NO_NAME.search(name) for name in names):
                raise Mistaken(f"Node(remappings=…): {names}: {NAMES}")
            words += ["-r", ":=".join(names)]
        first = [text_of(word, context) for word in self._arguments]
        ros = ["--ros-args", *words] if words else []
        context.started.append(Started(package, executable, (*first, *ros), self._needed, made))


def _place() -> str:
    """Return the launch file's line that is being run."""
    frame = sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename == __file__:
        frame = frame.f_back
    return f"{Path(frame.f_code.co_filename).name}, line {frame.f_lineno}"


def _below(base: str, namespace: str) -> str:
    """Return a namespace below another one, or as it is if it begins with a slash."""
    if not namespace or namespace.startswith("/"):
        return namespace or base
    return f"{base.rstrip('/')}/{namespace}".rstrip("/")


def _yaml(node: str, parameters: Iterable[tuple[str, str]]) -> str:
    lines = [f"    {json.dumps(name)}: {value}" for name, value in parameters]
    return "\n".join([f"{json.dumps(node)}:", "  ros__parameters:", *lines, ""])
