"""Have a colcon package read behind the wall: what it installs, and which programs are started.

The answer is a student's word. It decides which of the student's own files lie where in the node's
folder, and which of them are run; every path in it is checked against what was handed in.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path, PurePosixPath

from grader.colcon.frames import READ, Executable, Launched, PackageRead, ReadPackage
from grader.course.beside import MAX_FILES, PYTHON, listed, may_come
from grader.course.submission import (
    LAUNCH,
    ONLY_PYTHON,
    OTHER_LAUNCH,
    Package,
    Program,
    Submission,
    read_regular_file,
)
from rclpy_virtual_time import Excess, HostDied, HostForged, HostHung, Launcher

TELLS = re.compile(rb"remap|param|namespace|args")  # in a launch file, more than what to start
LIMIT = 20.0  # [s] for setup.py and a launch file
MAX_ARGUMENTS = 1024 * 1024  # [bytes] of all programs, half of what Linux takes


def unpacked(submission: Submission, launcher: Launcher) -> Submission:
    """Return the submission with a package's files as they are installed, and its programs.

    What is no package, or was read before, is returned as it is.
    """
    package = submission.package
    if package is None or package.programs or package.problem or submission.problem:
        return submission
    launch = package.start if package.start.endswith(LAUNCH) else ""
    if not package.start:
        launch = _launch_file(submission.beside, Path(package.main).stem)
    try:
        with submission.folder() as folder, launcher.host(folder) as link:
            order = ReadPackage(launch, package.folders)
            answer, _ = link.carry_out(READ, order, PackageRead, LIMIT)
    except (HostHung, HostDied, HostForged, Excess) as error:
        said = str(error) or "no answer"
        return replace(submission, problem=f"the package could not be read ({said})")
    if answer.problem:
        return replace(submission, problem=answer.problem)
    return _with_programs(submission, package, launch, answer)


def _launch_file(files: Mapping[str, Path], stem: str) -> str:
    """Return a package's launch file; "" if none or several may be meant.

    That is the file with the node's name, or the only file that no other includes.
    """
    found = [name for name in files if name.endswith(LAUNCH)]
    short = {name: PurePosixPath(name).name for name in found}
    mine = [n for n in found if stem and short[n].startswith((f"{stem}.", f"{stem}_"))]
    if len(found) > 1 and not mine:
        texts = {name: read_regular_file(files[name]) for name in found}
        mine = [
            name
            for name in found
            if not any(short[name].encode() in texts[each] for each in found if each != name)
        ]
    every = mine or found
    return every[0] if len(every) == 1 else ""


def _with_programs(
    submission: Submission, package: Package, launch: str, answer: PackageRead
) -> Submission:
    there = submission.beside
    installed = {
        place: there[source]
        for place, source in list(answer.files.items())[:MAX_FILES]
        if source in there and may_come(place) and _is_inside(place)
    }
    start = None if launch else there.get(package.start)
    if start and not package.main and start not in installed.values():  # python3 runs it, too
        home = PurePosixPath(package.start).parent
        installed |= {n: file for n, file in there.items() if PurePosixPath(n).parent == home}
    data = {name: path for name, path in there.items() if not name.endswith(PYTHON)}
    files = {**data, **installed}
    words = [w for each in answer.launched for w in (*each.arguments, *each.made.values())]
    above = {str(each) for place in files for each in PurePosixPath(place).parents}
    if clash := sorted(above & files.keys()):
        return replace(submission, problem=f"{clash[0]} would be a file and a folder")
    known = {_title(each.package, each.name, answer): each for each in answer.executables}
    every = tuple(
        Program(e.file, e.entry, name=e.name) for e in known.values() if e.file in installed
    )
    others = [] if launch else [name for name in there if OTHER_LAUNCH.search(name)]
    unread = [f"{name}: {ONLY_PYTHON}" for name in others]
    # in a grading: its node may be right only with what they say
    told = [n for n in others if package.main and TELLS.search(read_regular_file(there[n]))]
    held = answer.held or bool(told and not answer.unstarted)
    problem = answer.unstarted or (f"{listed(told)}: {ONLY_PYTHON}" if told else "")
    if problem and known and not package.main:
        problem += f"; its programs start alone as PACKAGE_FOLDER/NAME ({listed(list(known))})"
    if (
        package.main.endswith(LAUNCH)
        and package.folders
        and launch not in ("", *answer.files.values())
    ):
        problem = (
            problem or f"`ros2 launch` does not find {launch}: setup.py's data_files leave it out"
        )
    if sum(len(word.encode()) for word in words) > MAX_ARGUMENTS:
        problem = f"{launch} gives more arguments than a program can have"
    unstarted = replace(
        submission,
        beside=files,
        left=(*submission.left, *filter(str.isprintable, (*answer.notes, *unread))),
        package=replace(package, every=every, problem=problem, held=held),
    )
    if problem:
        return unstarted
    try:
        if launch:
            titles = [_title(each.package, each.executable, answer) for each in answer.launched]
            chosen = [known[title] for title in titles]
        else:
            chosen = [_executable(known, package, start, installed)]
        if broken := [each for each in chosen if each.file not in installed]:
            raise LookupError(broken[0].entry)
        programs = tuple(
            Program(
                each.file,
                each.entry,
                told.arguments,
                told.needed or bool(package.main and each.file.endswith(f"/{package.main}")),
                tuple(told.made.items()),
                each.name,
            )
            for each, told in zip(chosen, answer.launched or [Launched("", ())], strict=True)
        )
    except LookupError as error:
        problem = _no_program(error, answer, launch, there)
        if not launch and others:
            problem = f"{listed(others)}: {ONLY_PYTHON}"
            return replace(
                unstarted, package=replace(package, every=every, problem=problem, held=True)
            )
        if not launch:
            return replace(submission, problem=problem)
        return replace(unstarted, package=replace(package, every=every, problem=problem))
    main = next((p for p in programs if p.file.endswith(f"/{package.main}")), programs[0])
    return replace(
        submission,
        path=files[main.file],
        beside=files,
        left=unstarted.left,
        package=replace(package, programs=programs, every=every),
    )


def _executable(
    known: Mapping[str, Executable],
    package: Package,
    start: Path | None,
    installed: Mapping[str, Path],
) -> Executable:
    """Return the program to start: the named program, the exercise's, or the only one.

    A file that no entry point leads to runs as with `python3 FILE`, where no exercise wants more.
    Raises LookupError: there is none.
    """
    every = list(known.values())
    if package.start:
        every = [e for e in every if start and installed.get(e.file) == start] or [
            e for e in every if e.name == package.start
        ]
        wanted = package.start
        if start and not package.main and not every:
            place = next(place for place, source in installed.items() if source == start)
            return Executable(start.stem, place, "")
    else:
        wanted = package.main
        stem = Path(wanted).stem
        mine = [
            e for e in every if wanted and (PurePosixPath(e.file).name == wanted or e.name == stem)
        ]
        every, wanted = mine or every, wanted if len(mine) < 2 else ""
    if (not package.start and len(every) != 1) or not every:
        raise LookupError(wanted)
    return every[0]


def _no_program(
    error: LookupError, answer: PackageRead, launch: str, there: Collection[str]
) -> str:
    """Say that the program to start is missing, and which programs there are."""
    wanted = str(error.args[0])
    if wanted and wanted in (each.entry for each in answer.executables):
        said = f"the entry point {wanted} leads to no module that the package installs"
        file = PurePosixPath(f"{wanted.partition(':')[0].replace('.', '/')}.py")
        if str(file) not in there:
            return f"{said}: there is no {file}"
        if str(file.parent / "__init__.py") not in there:
            return f"{said}: {file.parent} has no __init__.py"
        return f"{said}: setup.py's `packages` leave it out"
    if not answer.executables:
        return (
            "the package has no entry point, so there is no program to start: name one in setup.py "
            "(entry_points, console_scripts)"
        )
    names = listed([_title(each.package, each.name, answer) for each in answer.executables])
    if launch and wanted.removesuffix(".py") in (each.name for each in answer.executables):
        name = wanted.removesuffix(".py")
        return f'{launch} starts {wanted}: the program is called {name}, so executable="{name}"'
    if launch:
        return f"{launch} starts {wanted}, but the package's entry points are: {names}"
    if not wanted:
        launches = [name for name in there if name.endswith(LAUNCH)]
        also = f"a launch file ({listed(launches)}), or " if launches else ""
        return (
            f"which program is to be started? Give `course` {also}an entry point as "
            f"PACKAGE_FOLDER/NAME ({names}); {ONLY_PYTHON}"
        )
    return f"no entry point of the package leads to {wanted}; setup.py has: {names}"


def _title(package: str, name: str, answer: PackageRead) -> str:
    """Return how a program is named: with its package, if there are several."""
    several = len({each.package for each in answer.executables}) > 1
    return f"{package} {name}" if several else name


def _is_inside(place: str) -> bool:
    path = PurePosixPath(place)
    plain = str(path) == place != "." and all(len(part.encode()) < 256 for part in path.parts)
    return plain and not path.is_absolute() and ".." not in path.parts and ":" not in place
