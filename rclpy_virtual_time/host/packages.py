"""Import packages of interfaces that lie beside a program, or are installed with it, as text.

What colcon has built goes first. If one file of a package is wrong, none can be imported, as on a
robot. Looking for them costs little, and nothing of ROS is imported before a program wants one.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from importlib.abc import Loader
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType
from typing import Any

KINDS = ("msg", "srv", "action")
MAX_BYTES = 100_000  # of a file
UNNAMED = "{0} has no {1}: its folder doesn't, or CMakeLists.txt (rosidl_generate_interfaces)"
NAME = re.compile(r"[a-z][a-z0-9_]*")


class Finder(Loader):
    """Finds modules such as `my_interfaces.msg` in these folders, and makes them."""

    def __init__(self, packages: dict[str, Path]) -> None:
        self._packages = packages

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        """Return the module's spec; None if it is none of these."""
        package, _, kind = name.partition(".")
        ours = package in self._packages and (path is None or bool(kind))
        if not ours or (kind and kind not in KINDS):
            return None
        return ModuleSpec(name, self, is_package=not kind)

    def exec_module(self, module: ModuleType) -> None:
        """Fill the module; what needs a package that is not here says so when it is imported.

        Raises ImportError: a file is wrong; it is named, with the line.
        """
        package, _, kind = module.__name__.partition(".")
        if not kind:
            return
        from .interfaces import define, definitions  # noqa: PLC0415

        lacking: dict[str, ImportError] = {}
        try:
            texts = {file.stem: _text(file) for file in _files(self._packages[package], kind)}
            made = define(package, texts, kind)
            vars(module).update(made)  # before they are looked up: they may refer to each other
            known: dict[Any, int] = {}
            for name, cls in made.items():
                try:
                    definitions.weigh(cls, known)
                except ModuleNotFoundError as error:
                    lacking[name] = error
        except ValueError as error:
            raise ImportError(str(error)) from None
        for name in lacking:
            delattr(module, name)

        def missing(name: str) -> Any:
            kind = AttributeError if name.startswith("__") else ImportError
            raise lacking.get(name) or kind(UNNAMED.format(module.__name__, name))

        module.__getattr__ = missing  # type: ignore[method-assign]


def offer(folders: Iterable[Path]) -> None:
    """Let a program import the packages in these folders; the first of a name counts."""
    found: dict[str, Path] = {}
    there = (each for f in folders if f.is_dir() for each in sorted(f.iterdir()))
    for each in (each for each in there if each.is_dir()):
        if any(_files(each, kind) for kind in KINDS) and not (each / "__init__.py").exists():
            spec = PathFinder.find_spec(each.name)
            built = spec is not None and spec.origin is not None
            if NAME.fullmatch(each.name) and not built and each.name not in sys.stdlib_module_names:
                found.setdefault(each.name, each)
    if found:
        sys.meta_path.insert(0, Finder(found))


def _files(folder: Path, kind: str) -> list[Path]:
    return sorted((folder / kind).glob(f"*.{kind}"))


def _text(file: Path) -> str:
    with file.open("rb") as opened:
        data = opened.read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise ValueError(f"{'/'.join(file.parts[-3:])}: at most {MAX_BYTES:,} bytes are read")
    return data.decode("utf-8", "replace")
