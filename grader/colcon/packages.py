"""Read colcon packages as `colcon build` does: what it installs, what `ros2 run` can start.

setup.py is a student's program like any other: it runs here, behind the wall, with a stand-in of
setuptools that notes what it is called with. setup.cfg and pyproject.toml are read, too.

Source: colcon-core, `task/python/build.py`; colcon-ros, `task/ament_python/build.py`; setuptools,
"Package Discovery" and "Entry Points".
"""

from __future__ import annotations

import configparser
import fnmatch
import os
import re
import runpy
import shutil
import sys
import tomllib
import traceback
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path, PurePosixPath
from types import ModuleType
from typing import Any
from xml.etree import ElementTree

import msgspec

from grader.advice import hints
from grader.colcon import launch_files, launch_stand_in, launch_texts
from grader.colcon.frames import Executable, Launched, PackageRead, ReadPackage
from grader.hosted.fields import sendable

ENTRY = re.compile(r"\s*([^=\s]+)\s*=\s*([\w.]+)\s*:\s*([\w.]+)\s*(?:\[.*\])?\s*")
INSTALL = re.compile(
    r"install\(\s*(DIRECTORY|FILES|PROGRAMS)\s+([^()]*?)\s+DESTINATION\s+([^\s)]+)"
)
LOOSE = "course_exercises"  # the package of programs that lie in none, as in a workspace
SETUPS = ("setup.py", "setup.cfg", "pyproject.toml")
INDEX = "share/ament_index/resource_index/packages"
SETTINGS = (
    "name", "packages", "package_dir", "py_modules", "data_files", "entry_points", "scripts",
    "package_data",
)  # fmt: skip
OURS = "|".join(["Context", *launch_stand_in.KNOWN.split(", ")])
NOT_IN_OURS = re.compile(rf"'({OURS})' object (has no attribute|is not)|operand .*'({OURS})'")
MAX_SAID = 300  # [characters]


class Unbuildable(Exception):
    """The package can't be built; the message says why."""


def carry_out(order: bytes) -> bytes:
    """Read a package, as a task of a host."""
    wanted = msgspec.msgpack.decode(order, type=ReadPackage)
    return msgspec.msgpack.encode(read(wanted.launch, wanted.folders))


def read(launch: str, folders: Iterable[str] = ("",)) -> PackageRead:
    """Return what the packages in these folders install and can start.

    Without folders, each file of Python beside the launch file is a program of the package LOOSE.
    """
    here = Path.cwd()
    files: dict[str, str] = {}  # what is installed: its place, its source
    executables: list[Executable] = []
    names = set[str]()
    owner, notes = "", list[str]()  # the package in which the launch file lies
    place = launch  # where it is installed
    started: list[launch_files.Started] = []
    try:
        for folder in folders:
            os.chdir(here / folder)
            package = _Built(here, here / folder)
            if package.name in names:
                raise Unbuildable(f"two packages are called {package.name}: colcon builds neither")
            names.add(package.name)
            files |= package.install()
            executables += package.executables(files)
            if PurePosixPath(launch).is_relative_to(folder or "."):
                owner = package.name
        os.chdir(here)
        if not names:
            owner, files = LOOSE, {file.name: file.name for file in here.glob("*.py")}
            executables = [Executable(Path(file).stem, file, "", LOOSE) for file in files]
    except BaseException as error:  # students' files may raise anything
        return PackageRead(sendable(_said(error, here)))
    unstarted, held = "", False
    try:
        if launch:
            shared = [place for place, source in files.items() if source == launch]
            place = next((each for each in shared if each.startswith("share/")), launch)
            having = frozenset(each.package for each in executables)
            started, notes = launch_files.read(place, owner, having)
        if launch and owner and not shared:
            notes.append(
                f"{launch} by `data_files`: `ros2 launch` does not find it, though it runs here"
            )
    except BaseException as error:
        unstarted, held = sendable(_said(error, here).replace(place, launch)), _is_ours(error)
    return PackageRead(
        unstarted=unstarted,
        held=held,
        files=files,
        executables=tuple(executables),
        launched=tuple(
            Launched(s.executable, s.arguments, s.package, s.needed, s.made) for s in started
        ),
        notes=tuple(map(sendable, notes)),
    )


class _Built:
    """A package as its setup describes it."""

    def __init__(self, root: Path, here: Path) -> None:
        self.name = _name(here)
        self._root, self._here = root, here
        self._settings = _settings(here, self.name)
        self._files: dict[str, str] = {}  # what is installed: its place, its source

    def install(self) -> dict[str, str]:
        """Return what is installed where; lay what is shared there, for launch files."""
        packages = self._settings.get("packages")
        for package in _found_packages(self._here) if packages is None else packages:
            self._install_package(str(package))
        for module in self._settings.get("py_modules") or ():
            self._add(f"{module}.py".replace(".", "/", module.count(".")), f"{module}.py")
        for place, sources in self._data_files():
            for source in sources:
                self._add(f"{place}/{PurePosixPath(source).name}", str(source))
        self._add(f"share/{self.name}/package.xml", "package.xml")
        marker = f"{INDEX}/{self.name}"
        if marker not in self._files:  # colcon makes it, and warns
            self._add(marker, "package.xml")
        for place, source in self._files.items():
            target = self._root / place
            if place.startswith("share/") and not target.exists():
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(self._root / source, target)
        return self._files

    def executables(self, files: dict[str, str]) -> list[Executable]:
        """Return what `ros2 run` can start; add scripts to the files that are installed."""
        entries = self._settings.get("entry_points") or {}
        if isinstance(entries, str):
            parser = _ini()
            parser.read_string(entries)
            entries = {section: dict(parser[section]) for section in parser.sections()}
        lines = entries.get("console_scripts") or ()
        if isinstance(lines, str):
            lines = lines.splitlines()
        if isinstance(lines, Mapping):
            lines = [f"{name} = {entry}" for name, entry in lines.items()]
        found = []
        for line in lines:
            if match := ENTRY.fullmatch(str(line)):
                name, module, function = match.groups()
                file, entry = self._file_of(module), f"{module}:{function}"
                found.append(Executable(name, file, entry, self.name))
        for script in self._settings.get("scripts") or ():
            place = f"lib/{self.name}/{PurePosixPath(str(script)).name}"
            self._add(place, str(script))
            found.append(Executable(PurePosixPath(place).name, place, "", self.name))
        files |= self._files
        return found

    def _file_of(self, module: str) -> str:
        path = module.replace(".", "/")
        places = (f"{path}.py", f"{path}/__init__.py")
        return next((place for place in places if place in self._files), "")

    def _install_package(self, package: str) -> None:
        folder = self._folder_of(package)
        place = package.replace(".", "/")
        if not folder.is_dir():
            raise Unbuildable(f"setup.py names the package {package}, but there is no such folder")
        data = self._settings.get("package_data") or {}
        patterns = ["*.py", *data.get("", ()), *data.get(package, ())]
        for pattern in patterns:
            for file in sorted(folder.glob(pattern)):
                if file.is_file():
                    inside = file.relative_to(folder).as_posix()
                    self._add(f"{place}/{inside}", str(file))

    def _folder_of(self, package: str) -> Path:
        """Return where a package's modules lie, as setuptools looks for it."""
        folders = self._settings.get("package_dir") or {}
        head, tail = package, list[str]()
        while head:
            if head in folders:
                return Path(self._here, folders[head], *tail).resolve()
            head, _, last = head.rpartition(".")
            tail.insert(0, last)
        return Path(self._here, folders.get("", ""), *tail).resolve()

    def _data_files(self) -> Iterable[tuple[str, list[str]]]:
        data = self._settings.get("data_files") or ()
        for entry in data.items() if isinstance(data, Mapping) else data:
            place, sources = entry
            yield str(place).rstrip("/"), [str(source) for source in sources]

    def _add(self, place: str, source: str) -> None:
        """Note what is installed.

        Raises Unbuildable: there is no such file, or it would lie elsewhere.
        """
        path = Path(self._here, source).resolve()
        if not path.is_file() or not path.is_relative_to(self._here):
            raise Unbuildable(f"the package installs {source}, but there is no such file in it")
        place = PurePosixPath(place).as_posix()
        if place.startswith("/") or ".." in PurePosixPath(place).parts:
            raise Unbuildable(f"{source} is installed into {place}, outside of share")
        self._files[place] = path.relative_to(self._root).as_posix()


def _name(here: Path) -> str:
    name = ElementTree.parse(here / "package.xml").findtext("name") or ""
    if not re.fullmatch(r"[a-z]\w*", name.strip()):
        raise Unbuildable(f"package.xml: expected a <name> such as my_agent, found {name[:40]!r}")
    return name.strip()


def _settings(here: Path, name: str) -> dict[str, Any]:
    """Return what setup.py, setup.cfg and pyproject.toml say; the first that says it counts."""
    found: dict[str, Any] = {}
    if not any((here / setup).is_file() for setup in SETUPS):
        return _cmake(here, name)
    for source in (_setup_py, _setup_cfg, _pyproject):
        for key, value in source(here).items():
            if value and key in SETTINGS:
                found.setdefault(key, value)
    return found


def _setup_py(here: Path) -> dict[str, Any]:
    if not (here / "setup.py").is_file():
        return {}
    called: list[dict[str, Any]] = []
    stand_in: Any = ModuleType("setuptools")
    stand_in.__path__ = []  # a package: `from setuptools.command import …`
    stand_in.setup = lambda *_, **given: called.append(given)
    stand_in.find_packages = stand_in.find_namespace_packages = (
        lambda where=".", exclude=(), include=("*",): _found_packages(
            here / where, exclude, include
        )
    )
    stand_in.__getattr__ = lambda name: type(name, (), {})  # Command, Extension
    names = ("setuptools", "setuptools.command", "setuptools.command.install", "distutils.core")
    with launch_files.standing_in(dict.fromkeys(names, stand_in)):
        sys.argv = ["setup.py", "install"]
        sys.path.insert(0, str(here))
        runpy.run_path("setup.py", run_name="__main__")
        sys.path.remove(str(here))
    if not called:
        raise Unbuildable("setup.py does not call setup(…)")
    return called[-1]


def _setup_cfg(here: Path) -> dict[str, Any]:
    parser = _ini()
    parser.read(here / "setup.cfg", "utf-8")
    options = dict(parser["options"]) if parser.has_section("options") else {}
    found: dict[str, Any] = {}
    for key in ("packages", "py_modules", "scripts"):
        found[key] = _lines(options.get(key, ""))
    folders = [line.partition("=") for line in _lines(options.get("package_dir", ""))]
    found["package_dir"] = {package.strip(): folder.strip() for package, _, folder in folders}
    if found["packages"] in (["find:"], ["find_namespace:"]):
        section = "options.packages.find"
        where = parser.get(section, "where", fallback=".")
        exclude = _lines(parser.get(section, "exclude", fallback=""))
        found["packages"] = _found_packages(here / where, exclude)
    if parser.has_section("options.entry_points"):
        found["entry_points"] = dict(parser["options.entry_points"])
    if parser.has_section("options.data_files"):
        found["data_files"] = [
            (place, [name for line in _lines(said) for name in _matching(here, line)])
            for place, said in parser["options.data_files"].items()
        ]
    return found


def _pyproject(here: Path) -> dict[str, Any]:
    if not (here / "pyproject.toml").is_file():
        return {}
    said = tomllib.loads((here / "pyproject.toml").read_text("utf-8"))
    own = said.get("tool", {}).get("setuptools", {})
    packages = own.get("packages")
    if isinstance(packages, Mapping):
        find = packages.get("find", {})
        where, exclude = (find.get("where") or ["."])[0], find.get("exclude", ())
        packages = _found_packages(here / where, exclude)
    return {
        "packages": packages,
        "package_dir": own.get("package-dir"),
        "py_modules": own.get("py-modules"),
        "package_data": own.get("package-data"),
        "data_files": {
            place: [name for line in lines for name in _matching(here, line)]
            for place, lines in own.get("data-files", {}).items()
        },
        "entry_points": {"console_scripts": said.get("project", {}).get("scripts", {})},
    }


def _cmake(here: Path, name: str) -> dict[str, Any]:
    """Return what CMakeLists.txt installs of files that need no building."""
    text = re.sub("#.*", "", (here / "CMakeLists.txt").read_text("utf-8"))
    text = text.replace("${PROJECT_NAME}", name)
    shared: list[tuple[str, list[str]]] = []
    scripts: list[str] = []
    for kind, sources, place in INSTALL.findall(text):
        for source in sources.replace('"', "").split():
            if kind == "PROGRAMS":
                scripts.append(source)
            elif kind == "FILES":
                shared.append((place, [source]))
            else:  # with a slash at its end, what is in it
                above = here / source if source.endswith("/") else (here / source).parent
                shared += [
                    (f"{place}/{file.parent.relative_to(above).as_posix()}", [str(file)])
                    for file in sorted((here / source).rglob("*"))
                    if file.is_file()
                ]
    own = re.findall(r"ament_python_install_package\(\s*(\w+)", text)
    packages = [p for n in own for p in _found_packages(here, (), (n, f"{n}.*"))]
    return {"packages": packages, "data_files": shared, "scripts": scripts}


def _found_packages(
    where: Path, exclude: Iterable[str] = (), include: Iterable[str] = ("*",)
) -> list[str]:
    """Return the packages below a folder, as `find_packages` does."""

    def matches(name: str, patterns: Iterable[str]) -> bool:
        return any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)

    exclude, include = list(exclude), list(include)
    found = []
    for file in sorted(where.rglob("__init__.py")):
        parts = file.parent.relative_to(where).parts
        above = [where.joinpath(*parts[:n], "__init__.py") for n in range(1, len(parts))]
        name = ".".join(parts)
        inside = bool(parts) and all(map(Path.is_file, above))
        if inside and matches(name, include) and not matches(name, exclude):
            found.append(name)
    return found


def _matching(here: Path, pattern: str) -> list[str]:
    found = [path.relative_to(here).as_posix() for path in sorted(here.glob(pattern))]
    return found or [pattern]


def _lines(text: str) -> list[str]:
    return [part.strip() for part in re.split(r"[\n,]", text) if part.strip()]


def _ini() -> configparser.ConfigParser:
    parser = configparser.ConfigParser(interpolation=None, delimiters=("=",))
    keep: Callable[[str], str] = str
    parser.optionxform = keep  # type: ignore[assignment,method-assign]
    return parser


def _is_ours(error: BaseException) -> bool:
    """Return whether a launch file is right, as far as is known, and only not read here."""
    frames = traceback.extract_tb(error.__traceback__)
    in_ours = frames[-1].filename in (launch_stand_in.__file__, launch_texts.__file__)
    lacks = NOT_IN_OURS.search(str(error)) and isinstance(error, AttributeError | TypeError)
    mistaken = isinstance(error, launch_files.Mistaken)
    return isinstance(error, launch_files.Unknown) or (not mistaken and bool(in_ours or lacks))


def _said(error: BaseException, here: Path) -> str:
    """Say what went wrong and in which of the package's lines."""
    frames = traceback.extract_tb(error.__traceback__)
    if isinstance(error, SyntaxError) and error.filename:
        where = f"{Path(error.filename).name}, line {error.lineno}: "
    else:
        own = [(here / f.filename, f.lineno) for f in frames]
        own = [(file, line) for file, line in own if file.is_relative_to(here)]
        where = f"{own[-1][0].relative_to(here)}, line {own[-1][1]}: " if own else ""
    if isinstance(error, Unbuildable | launch_files.Unknown | launch_files.Mistaken):
        place = getattr(error, "where", "")
        return (f"{place}: " if place else where) + str(error)
    foreign = re.search(rf"{launch_stand_in.FOREIGN}(\w+)", str(error))
    if foreign or type(error).__name__ == hints.NO_PACKAGE:
        return where + hints.no_package(f"'{foreign[1]}'" if foreign else str(error))
    if "Node.__init__() got an unexpected keyword" in str(error):
        return f"{where}{launch_stand_in.RCLPYS}"
    text = " ".join(str(error).split()).replace(f"{here}/", "")
    if isinstance(error, ModuleNotFoundError) and (more := hints.missing_package(error.name or "")):
        text += f"; {more}"
    return f"{where}{type(error).__name__}: {text}"[:MAX_SAID]
