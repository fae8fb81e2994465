"""What this Python itself needs of its environment to start again, in a host's, which is bare.

A Python that was moved, or that a module of a cluster brings, may find its own libraries through
LD_LIBRARY_PATH only. Hosts may read each folder named there, so they get those alone from which
this process really has libraries, and none that holds the course.
"""

from __future__ import annotations

import contextlib
import importlib
import os
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[2]
VARIABLE = "LD_LIBRARY_PATH"
NATIVE = ("ctypes", "ssl", "hashlib", "bz2", "lzma", "sqlite3", "zlib")  # with libraries of others
MAPS = Path("/proc/self/maps")

File = tuple[int, int]  # device and inode


def library_folders(
    environ: Mapping[str, str] | None = None, but: Collection[str] = ()
) -> tuple[Path, ...]:
    """Return the folders of LD_LIBRARY_PATH from which this interpreter has its libraries.

    `but`: folders that need no look. To look costs 20 ms and 6 MiB: modules have to be imported.
    """
    named = (folder for folder in _named(environ) if str(folder) not in but)
    found = [folder for folder in named if not CHECKOUT.is_relative_to(folder.resolve())]
    if not found:
        return ()
    loaded = set(_loaded())
    return tuple(folder for folder in found if not loaded.isdisjoint(_libraries(folder)))


def left_out(environ: Mapping[str, str] | None = None) -> tuple[Path, ...]:
    """Return the other folders of LD_LIBRARY_PATH, which hosts don't get."""
    kept = library_folders(environ)
    return tuple(folder for folder in _named(environ) if folder not in kept)


def with_needs(
    variables: Mapping[str, str], environ: Mapping[str, str] | None = None
) -> dict[str, str]:
    """Return a host's variables with what the interpreter needs, behind what is there."""
    home = (os.environ if environ is None else environ).get("PYTHONHOME", "")
    there = variables.get(VARIABLE, "").split(os.pathsep)  # ROS's wheels set the judge's, too
    folders = [*there, *map(str, library_folders(environ, there))]
    path = os.pathsep.join(dict.fromkeys(filter(None, folders)))
    return {**variables, VARIABLE: path, **({"PYTHONHOME": home} if home else {})}


def _named(environ: Mapping[str, str] | None) -> list[Path]:
    """Return the folders of LD_LIBRARY_PATH; an empty or a relative one means where one stands."""
    text = (os.environ if environ is None else environ).get(VARIABLE, "")
    named = [Path(part) for part in text.split(os.pathsep) if os.path.isabs(part)]  # noqa: PTH117
    return [folder for folder in dict.fromkeys(named) if folder.is_dir()]


def _loaded() -> Iterator[File]:
    """Yield the files that are mapped into this process, with those of its standard library."""
    for module in NATIVE:
        with contextlib.suppress(ImportError):
            importlib.import_module(module)
    with contextlib.suppress(OSError):
        lines = MAPS.read_text("utf-8", "replace").splitlines()
        paths = {line.split(maxsplit=5)[5] for line in lines if " /" in line}
        yield from _files(map(Path, paths))


def _libraries(folder: Path) -> set[File]:
    with contextlib.suppress(OSError):
        return set(_files(path for path in folder.iterdir() if ".so" in path.name))
    return set()


def _files(paths: Iterable[Path]) -> Iterator[File]:
    for path in paths:
        with contextlib.suppress(OSError):
            status = path.stat()
            yield status.st_dev, status.st_ino
