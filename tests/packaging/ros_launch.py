"""As much of `launch` and `launch_ros` as our launch files use, for machines without them.

Classes take what the real ones take and keep it; a launch file is then asked what it would start.
"""

import runpy
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest


@dataclass
class LaunchContext:
    launch_configurations: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class LaunchConfiguration:
    name: str

    def perform(self, context: LaunchContext) -> str:
        return context.launch_configurations[self.name]


@dataclass(frozen=True)
class IfCondition:
    predicate: LaunchConfiguration

    def evaluate(self, context: LaunchContext) -> bool:
        said = self.predicate.perform(context).lower()
        if said not in ("true", "1", "false", "0"):
            raise ValueError(said)
        return said in ("true", "1")


@dataclass
class DeclareLaunchArgument:
    name: str
    default_value: str | None = None
    description: str | None = None
    choices: Sequence[str] | None = None

    def visit(self, context: LaunchContext) -> None:
        given = context.launch_configurations
        if self.name not in given:
            if self.default_value is None:
                raise RuntimeError(f"{self.name} is required")
            given[self.name] = self.default_value
        if self.choices and given[self.name] not in self.choices:
            raise RuntimeError(f"{self.name}: expected one of {self.choices}")


@dataclass(kw_only=True)
class OpaqueFunction:
    function: Callable[..., list[Any] | None]


@dataclass(kw_only=True)
class Shutdown:
    reason: str = ""


@dataclass
class PythonLaunchDescriptionSource:
    location: str


@dataclass
class IncludeLaunchDescription:
    source: PythonLaunchDescriptionSource
    launch_arguments: Iterable[tuple[str, str]] = ()
    condition: IfCondition | None = None


@dataclass(kw_only=True)
class Node:
    executable: str
    package: str | None = None
    name: str | None = None
    parameters: Sequence[str | Mapping[str, Any]] = ()
    arguments: Sequence[str] = ()
    output: str = "log"
    on_exit: Shutdown | None = None
    condition: IfCondition | None = None


@dataclass
class LaunchDescription:
    entities: list[Any]


MODULES = {
    "launch": (LaunchContext, LaunchDescription),
    "launch.actions": (DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction, Shutdown),
    "launch.conditions": (IfCondition,),
    "launch.launch_description_sources": (PythonLaunchDescriptionSource,),
    "launch.substitutions": (LaunchConfiguration,),
    "launch_ros": (),
    "launch_ros.actions": (Node,),
}  # fmt: skip


def describe(file: Path) -> LaunchDescription:
    """Return what a launch file describes, made of the classes above."""
    with pytest.MonkeyPatch.context() as patch:
        for name, classes in MODULES.items():
            module = ModuleType(name)
            for each in classes:
                setattr(module, each.__name__, each)
            patch.setitem(sys.modules, name, module)
        return runpy.run_path(str(file))["generate_launch_description"]()


def arguments(file: Path) -> dict[str, DeclareLaunchArgument]:
    """Return the arguments that a launch file declares."""
    return {each.name: each for each in describe(file).entities
            if isinstance(each, DeclareLaunchArgument)}  # fmt: skip


def started(file: Path, **given: str) -> list[Node]:
    """Return the nodes that `ros2 launch FILE NAME:=VALUE …` would start, included files' too."""
    return _started(file, LaunchContext(dict(given)))


def _started(file: Path, context: LaunchContext) -> list[Node]:
    found: list[Node] = []
    waiting = list(describe(file).entities)
    while waiting:
        entity = waiting.pop(0)
        if isinstance(entity, DeclareLaunchArgument):
            entity.visit(context)
        elif isinstance(entity, OpaqueFunction):
            waiting = (entity.function(context) or []) + waiting
        elif entity.condition is not None and not entity.condition.evaluate(context):
            continue
        elif isinstance(entity, IncludeLaunchDescription):
            context.launch_configurations.update(entity.launch_arguments)
            found += _started(Path(entity.source.location), context)
        else:
            found.append(entity)
    return found
