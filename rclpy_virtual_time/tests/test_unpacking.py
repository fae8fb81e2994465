"""rclpy's Python out of wheels: the right versions, nothing native, all or nothing."""

import zipfile
from pathlib import Path

import pytest

from rclpy_portable import unpacking, wheels

ROOT = Path(__file__).resolve().parents[2]


def test_the_versions_are_those_of_the_constraints() -> None:
    lines = (ROOT / "constraints.txt").read_text("utf-8").splitlines()
    pinned = dict(line.split("==") for line in lines if "==" in line)
    assert {name: pinned.get(name) for name in wheels.VERSIONS} == wheels.VERSIONS


def wheel(folder: Path, package: str, prefix: str) -> None:
    with zipfile.ZipFile(folder / f"ros_{package}-1-cp312-cp312-linux.whl", "w") as made:
        made.writestr(f"{prefix}{package}/__init__.py", f"NAME = {package!r}\n")
        made.writestr(f"{prefix}{package}/_native.cpython-312.so", b"\x7fELF")
        made.writestr(f"{prefix}{package}/parser.py", "")
        made.writestr(f"ros_{package}-1.dist-info/METADATA", "")


@pytest.fixture
def source(tmp_path: Path) -> Path:
    folder = tmp_path / "wheels"
    folder.mkdir()
    for i, package in enumerate(wheels.PACKAGES):
        prefix = f"ros_{package}-1.data/data/lib/python3.12/site-packages/" if i % 2 else ""
        wheel(folder, package, prefix)
    return folder


def test_only_python_is_taken(source: Path, tmp_path: Path) -> None:
    target = tmp_path / "made" / "_ros"
    unpacking.unpack(target, source)
    there = {path.relative_to(target).as_posix() for path in target.rglob("*") if path.is_file()}
    names = {name for name in there if not name.endswith(".pyc")}
    assert {f"{package}/__init__.py" for package in wheels.PACKAGES} <= names
    assert not any(name.endswith(".so") for name in names)
    assert "rosidl_parser/parser.py" not in names
    assert "rclpy/_rclpy_pybind11.py" in names and "ros-rclpy 7.1" in (target / "NOTICE").read_text(
        "utf-8"
    )
    assert list(target.parent.iterdir()) == [target]  # nothing half made is left


def test_what_is_missing_is_named(source: Path, tmp_path: Path) -> None:
    next(source.glob("ros_std_msgs-*")).unlink()
    with pytest.raises(wheels.DownloadFailed, match="std_msgs"):
        unpacking.unpack(tmp_path / "_ros", source)
    assert not (tmp_path / "_ros").exists()


def test_what_came_from_other_versions_is_made_anew(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "made" / "_ros"
    unpacking.unpack(target, source)
    (target / "NOTICE").write_text("ros-rclpy 7.0.0\n", "utf-8")
    (target / "of_the_old").touch()
    monkeypatch.setattr(unpacking, "FOLDER", target)
    monkeypatch.setattr(unpacking, "_installed", lambda: source)
    said: list[str] = []
    assert unpacking.folder(said.append) == target
    assert len(said) == 1
    assert "ros-rclpy 7.1" in (target / "NOTICE").read_text("utf-8")
    assert not (target / "of_the_old").exists()
    unpacking.folder(said.append)
    assert len(said) == 1  # it stays
    assert list(target.parent.iterdir()) == [target]
