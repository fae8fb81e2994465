"""A Python that finds its own libraries through LD_LIBRARY_PATH only can have hosts."""

import os
from pathlib import Path

import pytest

from rclpy_virtual_time.link import interpreter
from rclpy_virtual_time.link.hosts import ROOT, ForkServer
from rclpy_virtual_time.link.interpreter import left_out, library_folders, with_needs
from rclpy_virtual_time.link.settings import EPOCH
from rclpy_virtual_time.tests.runs import run_beside_lidar


def mapped() -> Path:
    """A library that this process has loaded."""
    lines = Path("/proc/self/maps").read_text().splitlines()
    return next(Path(line.split()[-1]) for line in lines if ".so" in line and "/" in line)


@pytest.fixture
def needed(tmp_path: Path) -> Path:
    """A folder that holds a library of this process, under another name."""
    folder = tmp_path / "needed"
    folder.mkdir()
    (folder / "libneeded.so.1").symlink_to(mapped())
    return folder


def path_of(*folders: Path | str) -> dict[str, str]:
    return {"LD_LIBRARY_PATH": os.pathsep.join(map(str, folders))}


def test_a_folder_with_a_library_of_this_python_is_for_hosts_too(
    needed: Path, tmp_path: Path
) -> None:
    other = tmp_path / "other"
    other.mkdir()
    (other / "libsecret.so").write_text("no library of ours")
    environ = path_of(other, needed, other)

    assert library_folders(environ) == (needed,)
    assert left_out(environ) == (other,)


def test_what_would_open_more_is_no_folder_for_hosts(
    needed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(needed)  # what an empty or a relative entry means

    assert library_folders(path_of("", ".", tmp_path / "missing", mapped())) == ()
    assert library_folders(path_of(ROOT.parent, ROOT, "/")) == ()


def test_without_the_variable_nothing_is_added() -> None:
    assert with_needs({"A": "b", "LD_LIBRARY_PATH": "/x"}, {}) == {
        "A": "b", "LD_LIBRARY_PATH": "/x",
    }  # fmt: skip


def test_ros_comes_before_the_interpreters_own(needed: Path) -> None:
    found = with_needs({"LD_LIBRARY_PATH": "/ros/lib"}, path_of(needed) | {"PYTHONHOME": "/py"})

    assert found == {"LD_LIBRARY_PATH": f"/ros/lib:{needed}", "PYTHONHOME": "/py"}


def test_what_a_host_gets_anyway_needs_no_look(
    needed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """ROS's wheels name a dozen folders; to look, modules such as ssl would be imported."""
    monkeypatch.setattr(interpreter, "_loaded", None)
    there = {"LD_LIBRARY_PATH": str(needed)}
    assert with_needs(there, path_of(needed)) == there


def test_a_host_has_them(needed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An interpreter of an HPC module finds its libraries through this variable alone."""
    monkeypatch.setenv("LD_LIBRARY_PATH", str(needed))
    (tmp_path / "node.py").write_text("import os; print(os.environ['LD_LIBRARY_PATH'])")
    with ForkServer(EPOCH) as forkserver:
        recording = run_beside_lidar(forkserver, tmp_path, "node.py", seconds=0.1)

    assert str(needed) in recording.log[0].text.split(os.pathsep)
