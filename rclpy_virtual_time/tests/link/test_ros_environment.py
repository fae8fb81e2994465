"""ROS is found in each of the places where it may be installed."""

import os
import sys
from pathlib import Path
from unittest.mock import Mock

import pytest

from rclpy_virtual_time.link.errors import NoRos
from rclpy_virtual_time.link.practice import PracticeServer
from rclpy_virtual_time.link.ros_environment import RosEnvironment

VERSION = f"{sys.version_info.major}.{sys.version_info.minor}"


def install(folder: Path, version: str = VERSION, rclpy: str = "7.1.5") -> Path:
    """Make a folder look as if rclpy had been installed there."""
    (folder / f"rclpy-{rclpy}-py{version}.egg-info").mkdir(parents=True)
    package = folder / "rclpy"
    package.mkdir()
    (package / "__init__.py").touch()
    tag = version.replace(".", "")
    (package / f"_rclpy_pybind11.cpython-{tag}-x86_64-linux-gnu.so").touch()
    return folder


def bundle(folder: Path) -> list[Path]:
    names = ("ros_jazzy_rcl.libs", "ros_jazzy_rmw_fastrtps_cpp.libs")
    for name in names:
        (folder / name).mkdir(parents=True)
    return [folder / name for name in names]


@pytest.fixture
def venv(tmp_path: Path) -> Path:
    folder = install(tmp_path / "venv" / "lib" / f"python{VERSION}" / "site-packages")
    bundle(folder)
    return folder


@pytest.fixture
def apt(tmp_path: Path) -> dict[str, str]:
    found = sourced(tmp_path, "jazzy", "7.1.5")
    del found["ROS_DISTRO"]
    root = found["AMENT_PREFIX_PATH"]
    return found | {"LD_LIBRARY_PATH": f"{root}/opt/rviz/lib:{root}/lib"}


def sourced(tmp_path: Path, distro: str, rclpy: str, python: str = VERSION) -> dict[str, str]:
    root = tmp_path / "opt" / "ros" / distro
    packages = install(root / "lib" / f"python{python}" / "site-packages", python, rclpy)
    return {"AMENT_PREFIX_PATH": str(root), "PYTHONPATH": str(packages), "ROS_DISTRO": distro}


def test_wheels_in_a_venv(venv: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [str(venv), *sys.path])
    ros = RosEnvironment.find({}, [venv])

    assert ros.kind == "wheels"
    assert ros.python_path == (venv,)
    prefix = venv.parents[2]
    assert ros.prefixes == (prefix,)
    assert ros.library_path == (
        venv / "ros_jazzy_rcl.libs",
        venv / "ros_jazzy_rmw_fastrtps_cpp.libs",
        prefix / "lib",
    )
    variables = ros.variables()
    assert (variables["ROS_DISTRO"], variables["_ROS_WHEELS_BOOTSTRAP_COMPLETE"]) == ("jazzy", "1")
    assert variables["LD_LIBRARY_PATH"].split(os.pathsep)[-1] == str(prefix / "lib")


def test_wheels_under_debians_python(tmp_path: Path) -> None:
    lib = tmp_path / "usr" / "local" / "lib" / f"python{VERSION}"
    wheels = install(lib / "site-packages")
    libraries = [*bundle(wheels), *bundle(lib / "dist-packages")]  # next door
    (lib / "dist-packages" / "rclpy").mkdir(parents=True)  # the empty shell
    ros = RosEnvironment.find({}, [lib / "dist-packages", wheels])

    assert ros.kind == "system wheels"
    assert ros.python_path == (wheels,)
    assert ros.prefixes == (tmp_path / "usr" / "local",)
    assert set(libraries) < set(ros.library_path)


def test_a_sourced_apt_installation_comes_first(apt: dict[str, str], venv: Path) -> None:
    ros = RosEnvironment.find(apt, [venv])

    assert ros.kind == "apt"
    assert [str(path) for path in ros.python_path] == [apt["PYTHONPATH"]]
    assert ros.variables()["LD_LIBRARY_PATH"] == apt["LD_LIBRARY_PATH"]
    assert ros.variables()["AMENT_PREFIX_PATH"] == apt["AMENT_PREFIX_PATH"]


def test_a_workspace_on_top(apt: dict[str, str], tmp_path: Path) -> None:
    workspace = tmp_path / "ws" / "install" / "my_package"
    overlaid = {
        **apt,
        "AMENT_PREFIX_PATH": f"{workspace}:{apt['AMENT_PREFIX_PATH']}",
        "PYTHONPATH": f"{workspace}/lib:{apt['PYTHONPATH']}:",
    }
    ros = RosEnvironment.find(overlaid, [])

    assert ros.prefixes == (workspace, Path(apt["AMENT_PREFIX_PATH"]))
    assert len(ros.python_path) == 2


NOTHING = "none", "shell", "no libraries", "another Python", "not sourced", "half sourced"


@pytest.mark.parametrize("layout", NOTHING)
def test_without_ros_it_says_how_to_install_it(
    layout: str, tmp_path: Path, apt: dict[str, str]
) -> None:
    folder = tmp_path / "lib" / "python" / "site-packages"
    environ: dict[str, str] = {}
    match layout:
        case "shell":
            (folder / "rclpy").mkdir(parents=True)
            bundle(folder)
        case "no libraries":
            install(folder)
        case "another Python":
            install(folder, "2.7")
            bundle(folder)
        case "not sourced":
            environ = {"PYTHONPATH": apt["PYTHONPATH"]}
        case "half sourced":
            environ = {"AMENT_PREFIX_PATH": apt["AMENT_PREFIX_PATH"], "PYTHONPATH": ""}
    with pytest.raises(NoRos) as caught:
        RosEnvironment.find(environ, [folder])

    said = str(caught.value)
    assert "pip install" in said
    assert "/opt/ros/jazzy/setup.bash" in said
    assert "\n" not in said


def test_a_sourced_ros_without_rclpy_is_named() -> None:
    with pytest.raises(NoRos, match=r"^ROS 2 Jazzy is sourced, but has no rclpy for Python"):
        RosEnvironment.find({"ROS_DISTRO": "jazzy"}, [])


def test_the_real_one() -> None:
    ros = RosEnvironment.find()

    assert any((path / "rclpy" / "__init__.py").is_file() for path in ros.python_path)
    assert all(path.is_dir() for path in ros.library_path)


def test_kilted_is_graded_too(tmp_path: Path, venv: Path) -> None:
    ros = RosEnvironment.find(sourced(tmp_path, "kilted", "9.1.1"), [venv])

    assert (ros.kind, ros.variables()["ROS_DISTRO"]) == ("apt", "kilted")
    wheels = bundle(install(tmp_path / "lib/python/site-packages", rclpy="9.1.2"))[0].parent
    assert RosEnvironment.find({}, [wheels]).distro == "kilted"


@pytest.mark.parametrize(
    ("distro", "rclpy", "python", "here"),
    [
        ("lyrical", "10.0.3", VERSION, "ROS 2 Lyrical"),
        ("lyrical", "10.0.3", "2.7", "ROS 2 Lyrical"),  # for another Python than this
        ("humble", "3.3.12", VERSION, "ROS 2 Humble"),
        ("", "10.0.3", VERSION, "rclpy 10.0"),
        ("kilted", "9.2.0", VERSION, "rclpy 9.2"),  # a workspace of its own on top
    ],
)
def test_another_rclpy_is_named_and_nothing_is_installed_over_it(
    distro: str, rclpy: str, python: str, here: str, tmp_path: Path, venv: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    environ = sourced(tmp_path, distro, rclpy, python)
    assert "wheels" in RosEnvironment.find(environ, [venv]).kind
    with pytest.raises(NoRos, match=rf"^{here} is here.*, expected Jazzy or Kilted: ") as caught:
        RosEnvironment.find(environ, [])
    assert caught.value.here == here
    assert "in a fresh virtual environment" in str(caught.value)
    refused = NoRos(str(caught.value), here)
    monkeypatch.setattr(RosEnvironment, "find", Mock(side_effect=refused))
    assert PracticeServer.words().startswith(f"{here} is here; this is Jazzy's portable copy, for")
