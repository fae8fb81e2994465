"""Read a launch file, with a small stand-in of `launch` and `launch_ros`.

PyPI has no wheels of them. A launch file is a program: it runs here, behind the wall. What it
starts comes out as command lines; what the stand-in (`launch_stand_in`, `launch_texts`) does not
know is named in one line.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from grader.colcon import launch_stand_in, launch_texts
from grader.colcon.launch_stand_in import KNOWN
from grader.colcon.launch_texts import Context, Mistaken, Started, Unknown

__all__ = ["Mistaken", "Started", "Unknown", "read", "standing_in"]


def read(
    file: str, package: str, packages: frozenset[str] = frozenset()
) -> tuple[list[Started], list[str]]:
    """Return what a launch file starts of its package and others, and what is left out.

    Raises Unknown: it has something that is not known here.
    Raises Mistaken: it is wrong.
    """
    here = Path.cwd()
    paths = (str(here), os.environ.get("AMENT_PREFIX_PATH", ""))
    os.environ["AMENT_PREFIX_PATH"] = os.pathsep.join(filter(None, paths))
    context = Context(package, packages | {package})
    with standing_in(_modules()), _foreign_packages():
        launch_stand_in.include(file, context)
    if not context.started:
        own = package or ", ".join(packages)
        raise Mistaken("; ".join([f"{file} starts no node of the package {own}", *context.notes]))
    for each in context.started:  # the package lies elsewhere when the nodes run
        if launch_stand_in.FOREIGN in (needs := " ".join((*each.arguments, *each.made.values()))):
            raise FileNotFoundError(needs)
        each.arguments = tuple(word.replace(f"{here}/", "") for word in each.arguments)
        each.made = {name: text.replace(f"{here}/", "") for name, text in each.made.items()}
    return context.started, context.notes


@contextlib.contextmanager
def _foreign_packages() -> Iterator[None]:
    """Let a launch file ask where packages lie that are not here; what it includes is left out."""
    packages: Any = importlib.import_module("ament_index_python.packages")  # comes with ROS
    find = packages.get_package_prefix

    def found(name: str) -> str:
        with contextlib.suppress(packages.PackageNotFoundError):
            return str(find(name))
        return f"{launch_stand_in.FOREIGN}{name}"

    packages.get_package_prefix = found
    try:
        yield
    finally:
        packages.get_package_prefix = find


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


def _modules() -> dict[str, ModuleType]:
    """Return the stand-ins, by the names that launch files import them by."""
    has = {
        "launch": "LaunchDescription Substitution",
        "launch.actions":
            "DeclareLaunchArgument GroupAction IncludeLaunchDescription LogInfo OpaqueFunction "
            "Shutdown TimerAction",
        "launch.conditions": "IfCondition UnlessCondition",
        "launch.event_handlers": "",
        "launch.launch_description_sources": "PythonLaunchDescriptionSource",
        "launch.substitutions":
            "LaunchConfiguration PathJoinSubstitution TextSubstitution ThisLaunchFileDir",
        "launch_ros": "",
        "launch_ros.actions": "Node PushROSNamespace SetParameter SetRemap",
        "launch_ros.descriptions": "ParameterFile ParameterValue",
        "launch_ros.parameter_descriptions": "ParameterFile ParameterValue",
        "launch_ros.substitutions": "FindPackageShare",
    }  # fmt: skip
    known = {**vars(launch_texts), **vars(launch_stand_in)}
    made = {
        name: _module(name, {each: known[each] for each in own.split()})
        for name, own in has.items()
    }
    made["launch_ros.actions"].__dict__["PushRosNamespace"] = launch_stand_in.PushROSNamespace
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

        def refuse(*_: object, **__: object) -> None:  # what is imported only, does no harm
            raise Unknown(f"{name}.{wanted} is not known here; a launch file may have {KNOWN}")

        return type(wanted, (), {"__new__": refuse})

    module.__getattr__ = lacks
    found: ModuleType = module
    return found
