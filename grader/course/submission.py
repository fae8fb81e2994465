"""A student's submission: find the files, and check what can be checked without running them.

All files that somebody handed in are read here, and no link is followed: it may lead to another
student's answer, or to the instructor's files. Only the file that a person names on the command
line may be a link, because it is that person's own.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from grader.course import interfaces
from grader.course.beside import MANIFEST, MAX_BYTES, MAX_FILES, beside, listed
from grader.course.untouched import untouched
from grader.errors import InputError
from rclpy_virtual_time import fresh_folder, open_regular_file

MAX_SIZE = 1024 * 1024  # [bytes] of a student's file
SHARE = "share/"  # what a package installs there lies elsewhere in it, too
NOT_SAID = re.compile(r"(^|/)(exercise\.toml|test_\w+\.py)$")  # the course's own; `course start`'s
POINTER = b"version https://git-lfs.github.com/spec/"  # how one begins
SETUPS = ("setup.py", "setup.cfg", "pyproject.toml")
PROGRAMS = re.compile(rb"^\s*(install\(\s*PROGRAMS|ament_python_install_package)\b", re.MULTILINE)
LAUNCH = "launch.py"  # the end of a launch file's name
OTHER_LAUNCH = re.compile(r"launch\.(xml|ya?ml)$|(^|/)launch/[^/]+\.(xml|ya?ml)$")
ONLY_PYTHON = "of launch files only those in Python are read here"
IGNORED = ("COLCON_IGNORE", "AMENT_IGNORE")  # in a package that colcon leaves out
MODULES = 6  # folders of modules in one another, up to the package
MOST_LOOKED_AT = 200  # entries of a folder, for a package


@dataclass(frozen=True)
class Program:
    """A program of a package, as `ros2 run` starts it."""

    file: str  # of its module, below the working folder
    entry: str = ""  # "module:function"; "": the file itself is run
    arguments: tuple[str, ...] = ()  # of its command line, as a launch file has them
    needed: bool = False  # the others end with it
    made: tuple[tuple[str, str], ...] = ()  # files that a launch file writes: name and YAML
    name: str = field(default="", compare=False)  # of the executable


@dataclass(frozen=True)
class Package:
    """A colcon package: the program to start, and the programs read out of it."""

    start: str = ""  # the launch file, module's file or entry point to start; "": the only one
    main: str = ""  # the file that the exercise wants; "" if it is for none
    others: tuple[str, ...] = ()  # the exercise's other files
    programs: tuple[Program, ...] = ()  # to start together; () before it is read
    every: tuple[Program, ...] = ()  # that could be started
    folders: tuple[str, ...] = ("",)  # the packages'; none: a launch file beside its programs
    problem: str = ""  # why its launch file can't be started ...
    held: bool = False  # ... here: a person has to look


@dataclass(frozen=True)
class Submission:
    """A node's file with its accompanying files, and the reason if it can't be run."""

    path: Path
    problem: str = ""  # the student's mistake, found before the run; "" if none
    others: tuple[Path, ...] = ()  # the exercise's other files, beside it
    beside: Mapping[str, Path] = field(default_factory=dict)  # what else comes along, by its place
    left: tuple[str, ...] = ()  # what does not, and why
    package: Package | None = None  # the files are a colcon package

    @property
    def files(self) -> dict[str, Path]:
        """The files of the node's working folder, by path there."""
        own = () if self.package else (self.path, *self.others)
        return {**self.beside, **{path.name: path for path in own}}

    def contents(self) -> dict[str, bytes]:
        """Return the content of each file."""
        own = (self.path, *self.others)
        return {
            name: read_regular_file(path, MAX_SIZE if path in own else MAX_BYTES)
            for name, path in self.files.items()
        }

    def started(self, name: str = "") -> tuple[Program, ...]:
        """Return the programs to start for a file of the exercise; by default for the main file."""
        if self.package is None:
            return (Program(name or self.path.name),)
        if name and name != self.package.main:
            launched = self.package.programs if self.package.folders else ()
            if self.package.main.endswith(LAUNCH):  # alone, without what that says
                launched = tuple(
                    Program(p.file, p.entry, name=p.name) for p in self.package.programs
                )
            every = (*launched, *self.package.every)
            mine = (e for e in every if f"/{self.plays(e)}".endswith(f"/{name}"))
            return tuple(itertools.islice(mine, 1))
        rest = tuple(f"/{other}" for other in self.package.others)
        main = tuple(each for each in self.package.programs if not each.file.endswith(rest))
        return main or self.package.programs

    def plays(self, program: Program) -> str:
        """Return which of the exercise's files a program is: by its file's name, or its own."""
        wanted = (*self.package.others, self.package.main) if self.package else ()
        names = (PurePosixPath(program.file).name, f"{program.name}.py")
        return next((name for name in names if name in wanted), program.file)

    @contextlib.contextmanager
    def folder(self, without: Collection[str] = ()) -> Iterator[Path]:
        """Copy the files into a fresh folder, whose owner may be changed.

        Accompanying files at or below `without` are skipped: the judge puts its own there, and
        no file of the submission itself has such a name.
        """
        kept = {PurePosixPath(name) for name in without if name}
        with fresh_folder() as folder:
            for name, content in self.contents().items():
                place = PurePosixPath(name)
                if name in self.beside and not kept.isdisjoint((place, *place.parents[:-1])):
                    continue
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                (folder / name).write_bytes(content)
            yield folder

    def _untouched(self) -> str:
        if self.package or self.problem:
            return ""
        own = (self.path, *self.others)
        with contextlib.suppress(OSError):
            return untouched({path.name: read_regular_file(path) for path in own})
        return ""

    def _is_pointer(self, name: str) -> bool:
        with contextlib.suppress(OSError):
            return read_regular_file(self.files[name], len(POINTER)).startswith(POINTER)
        return False

    def account(self) -> list[str]:
        """Return sentences on the accompanying files, and on those left out."""
        own = [] if self.package else [path.name for path in (self.path, *self.others)]
        more = {name: file for name, file in self.files.items() if name not in own}
        said_of = {file for name, file in more.items() if not name.startswith(SHARE)}
        came = sorted(
            name
            for name, file in more.items()
            if not NOT_SAID.search(name) and not (name.startswith(SHARE) and file in said_of)
        )
        said = [skeleton] if (skeleton := self._untouched()) else []
        said += [f"With the node came {listed(came)}."] if came else []
        if pointers := [name for name in came if self._is_pointer(name)]:
            said.append(
                f"{listed(pointers)}: only a Git LFS pointer, which stands for the file; "
                "`git lfs pull` brings the file itself."
            )
        said += [f"{note}." for note in self.left if note.startswith(interfaces.STOPS)]
        left = [each for each in self.left if not each.startswith(interfaces.STOPS)]
        return [*said, *([f"Left behind: {'; '.join(left)}."] if left else [])]


def find_submission(
    path: Path, expected: str | None = None, others: Sequence[str] = ()
) -> Submission:
    """Return the submission at `path`: a file, a folder that holds `expected`, a colcon package.

    What lies in the file's folder comes along; the exercise's other files belong to the submission.
    If an exercise has several files (`expected` and `others`), `path` may be any of them. `path`
    itself may be a link; what is found in a folder or beside it may not.

    Raises InputError: there is no such file, or one is a link.
    """
    if path.is_file() and OTHER_LAUNCH.search(path.as_posix()):
        raise InputError(f"{path}: {ONLY_PYTHON}")
    if (place := _packages_of(path, expected)) is not None:
        return _in_packages(*place, path, expected, others)
    if path.is_dir():
        path = _in_folder(path, expected)
    elif not path.exists():
        raise InputError(f"{path}: no such file; expected a Python file or a folder with one")
    elif not path.is_file():
        raise InputError(f"{path}: expected a Python file, but this is not a regular file")
    if expected and path.name in others:
        others = [expected, *others]
        if expected.endswith(LAUNCH):  # it starts the others
            path = file_beside(path, expected) or path
    names = [name for name in dict.fromkeys(others) if name != path.name]
    found = tuple(file for name in names if (file := file_beside(path, name)) is not None)
    path = path.resolve()
    launched = path.name.endswith(LAUNCH)  # what is wrong in one file says nothing of the others
    problems = [_problem(file, launched=launched) for file in (path, *found)]
    problem = next(filter(None, problems), "")
    there = beside(path.parent)  # as Python has it, where a link leads
    tops = dict.fromkeys(n[: n.find("/") + 1] for n in there.files if "/" in n)
    files, said = interfaces.taken(there.files, tops)
    own, more = ({}, []) if expected else _interfaces_around(path)
    left = (*there.left, *said, *more)
    if launched:
        every = {**own, **files, **{file.name: file for file in (path, *found)}}
        return Submission(path, problem, found, every, left, Package(path.name, folders=()))
    mine = {path.name, *(file.name for file in found)}
    beside_it = {n: file for n, file in {**own, **files}.items() if n not in mine}
    return Submission(path, problem, found, beside_it, left)


def file_beside(path: Path, name: str) -> Path | None:
    """Return the file called `name` beside `path`; None if there is none.

    Raises InputError: it is a link.
    """
    file = path.parent.resolve() / name
    if file.is_symlink():
        raise InputError(
            f"{path.with_name(name)}: a link, which is not followed, since it may lead to "
            "somebody else's file; expected the file itself"
        )
    return file if file.is_file() else None


def read_regular_file(path: Path, limit: int = MAX_SIZE) -> bytes:
    """Return the first `limit` + 1 bytes of a submitted file; no link is followed.

    Raises OSError: it can't be read, or is not a regular file.
    """
    with open_regular_file(path) as file:
        return file.read(limit + 1)


def _packages_of(path: Path, expected: str | None) -> tuple[Path, list[Path]] | None:
    """Return a folder and those of the colcon packages in it; None if no package is meant.

    A file is run as `python3 FILE` runs it, unless it is a module of a package's or a launch file.
    A folder may be a package or a workspace; of a launch file it is the `src` around its package,
    but not where a certain file is `expected`: what lies around may be another student's then. One
    in no package that lies beside programs starts these.
    """
    path = Path(os.path.normpath(path.absolute()))  # without "..", or nothing lies around it
    if path.is_dir():
        if is_package(path):
            return path, [path]
        if expected is not None and (path / expected).exists():
            return None
        if any(map(is_package, found := _packages_in(path))):
            return path, found
    if (path.is_dir() and expected is None) or not path.exists():  # maybe an entry point's name
        return (path.parent, [path.parent]) if is_package(path.parent) else None
    if path.is_dir():
        return None
    near = [path.parent, *path.parents[1:MODULES]]
    if path.name.endswith(LAUNCH):
        home = next((each for each in near if (each / MANIFEST).is_file()), None)
        programs = [file for file in path.parent.glob("*.py") if not file.name.endswith(LAUNCH)]
        if home is None and programs and expected in (None, path.name):
            return None
        around = next((each for each in near if each.name == "src"), None) if home else path.parent
        found = _packages_in(around) if around and expected is None else []
        if around and any(map(is_package, found)) and (home is None or home in found):
            return around, found
        if home is None or not is_package(home):
            raise InputError(
                f"{path}: expected a launch file beside its programs, in a package with a "
                "setup.py, in another of the same src folder, or in the folder with the packages"
            )
        return home, [home]
    home = next((each for each in near[1:] if is_package(each)), None)
    inside = (path.parent / "__init__.py").is_file()
    if home and not inside and expected is None:  # it may import what is installed of its package
        own = "|".join(each.parent.name for each in home.glob("*/__init__.py")) or "$."
        imports = rf"^\s*(?:from|import)\s+(?:{own})\b".encode()
        inside = bool(re.search(imports, read_regular_file(path), re.MULTILINE))
    return (home, [home]) if home and inside else None


def _packages_in(folder: Path) -> list[Path]:
    """Return the packages in a folder and in those in it, but for what colcon makes."""
    inside = [e for depth in ("*", "*/*") for e in sorted(folder.glob(depth))[:MOST_LOOKED_AT]]
    return [
        each
        for each in inside
        if is_package(each, (*SETUPS, "CMakeLists.txt"))
        and not each.is_symlink()
        and not any((folder / name).exists() for folder in (each, each.parent) for name in IGNORED)
        and each.parent.name not in ("build", "install", "log")
    ]


def _interfaces_around(path: Path) -> tuple[dict[str, Path], list[str]]:
    """Return the interfaces of packages in the `src` of a file or a package; see `taken`."""
    near = [path, *path.parents[:MODULES]]
    home = next((each for each in near if (each / MANIFEST).is_file()), None)
    if home is None:
        return {}, []
    around = next((each for each in near if each.name == "src"), home.parent)
    having = [e for e in _packages_in(around) if any((e / k).is_dir() for k in interfaces.KINDS)]
    tops = {f"{each.relative_to(around).as_posix()}/": each for each in having}
    inside = {top + n: file for top, e in tops.items() for n, file in beside(e).files.items()}
    found, said = interfaces.taken(inside, tops)
    shared = ((name, file) for name, file in found.items() if name.startswith(SHARE))
    return dict(itertools.islice(shared, MAX_FILES)), said


def is_package(folder: Path, setups: Sequence[str] = SETUPS) -> bool:
    """Return whether a folder is a package that colcon builds, by default with setuptools."""
    there = [name for name in (MANIFEST, *setups) if (folder / name).is_file()]
    built = folder / interfaces.BUILD  # with CMake, which installs Python, too
    if there == [MANIFEST] and built.is_file() and not built.is_symlink():
        return bool(PROGRAMS.search(read_regular_file(built)))
    return there[:1] == [MANIFEST] and len(there) > 1


def _in_packages(
    root: Path, folders: Sequence[Path], path: Path, expected: str | None, others: Sequence[str]
) -> Submission:
    places = tuple("" if each == root else each.relative_to(root).as_posix() for each in folders)
    path = Path(os.path.normpath(path.absolute()))
    start, root = "" if path == root else path.name, root.resolve()
    if path.is_file():
        start = (path.parent.resolve() / path.name).relative_to(root).as_posix()
    home = next((place for place in places if f"{start}/".startswith(f"{place}/")), "")
    there = beside(root, home)
    whole = (p for p in places if not any(name.startswith(f"{p}/") for name in there.over))
    places = (home, *(p for p in whole if p != home)) if home else places
    manifests = [f"{place}/{MANIFEST}".removeprefix("/") for place in places]
    needed = [*manifests, *([start] if path.is_file() else [])]
    if lacks := [name for name in needed if name not in there.files]:
        raise InputError(
            f"{root / lacks[0]}: a link, too large, or beyond the {MAX_FILES} files that come "
            "along; expected packages of ordinary files"
        )
    tops = tuple(f"{place}/".removeprefix("/") for place in places)
    kept = {n: file for n, file in there.files.items() if n == start or n.startswith(tops)}
    own, more = _interfaces_around(folders[0]) if expected is None else ({}, [])
    kept, said = interfaces.taken({**own, **kept}, tops)
    wanted = (expected, *others) if expected else ()
    if (named := Path(start).name) in wanted:
        wanted = (named, *(name for name in wanted if name != named))
    mine = [
        next((file for name, file in kept.items() if Path(name).name == want), None)
        for want in wanted
    ]
    first, *rest = mine or [None]
    package = Package(start, wanted[0] if wanted else "", wanted[1:], folders=places)
    found = tuple(file for file in rest if file is not None)
    problem = next(filter(None, (_problem(file) for file in mine if file)), "")
    main = first or kept.get(start) or kept[manifests[0]]
    left = (*there.left, *dict.fromkeys((*said, *more)))
    return Submission(main, problem, found, kept, left, package)


def _in_folder(folder: Path, expected: str | None) -> Path:
    if (folder / MANIFEST).is_file():
        raise InputError(
            f"{folder}: a package without setup.py, so there is no program to start; give the "
            "node's file, or the workspace with the packages that it starts"
        )
    if expected is None:
        raise InputError(f"{folder}: expected a Python file, but this is a folder")
    path = folder / expected
    if file_beside(path, expected) is None:
        there = sorted(file.name for file in folder.glob("*.py"))[:5]
        found = f"it holds {', '.join(there)}" if there else "it holds no Python file"
        raise InputError(f"{folder}: expected a file {expected} in this folder; {found}")
    return path


def _problem(path: Path, *, launched: bool = False) -> str:
    if not path.name.isprintable():  # not UTF-8, or with control characters
        raise InputError(f"{str(path)!r}: give the file a name of ordinary characters")
    try:
        content = read_regular_file(path)
        if len(content) > MAX_SIZE:
            size = path.stat().st_size
            return f"the file has {size:,} bytes; at most {MAX_SIZE:,} are read"
        if launched:
            return ""
        if not content.strip():
            return "the file is empty: was it saved?"
        return _unencoded(content)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None


def _unencoded(content: bytes) -> str:
    """Say where Python could not read a file's letters; "" where it can, or the file declares how.

    Nothing is looked up by a name that the file has: it may be any.
    """
    if b"coding" in b"".join(content.splitlines()[:2]):
        return ""
    try:
        content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        return f"line {line} has a letter that is not UTF-8; save the file as UTF-8 in your editor"
    return ""
