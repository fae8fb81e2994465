"""`prepare` and the first cell: what lacks is installed, and nothing restarts.

`tests/journeys/test_notebook_begun.py` does all of it on a real bare system Python.
"""

import ast
import json
import os
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest
from kernels import Kernel

from grader.errors import InputError
from grader.notebook import preparation
from grader.notebook.bootstrap import BOOTSTRAP, with_address
from rclpy_virtual_time import NoRos, RosEnvironment

ROOT = Path(preparation.__file__).resolve().parents[2]
WHEEL = "rclpy_agents_course"  # the one package of the wheel
FAKE_PIP = """\
import json, os, sys
with open(os.environ["SEEN"], "w") as file:
    json.dump([sys.argv[1:], os.environ.get("PIP_BREAK_SYSTEM_PACKAGES")], file)
print(os.environ.get("SAY", ""))
raise SystemExit(int(os.environ.get("EXIT", "0")))
"""


# --- the first cell ------------------------------------------------------------------------------


def test_the_first_cell_needs_only_python() -> None:
    tree = ast.parse(BOOTSTRAP, feature_version=(3, 7))  # old ones have to understand it
    top = [n for n in ast.walk(tree) if isinstance(n, ast.Import)]
    names = {alias.name.partition(".")[0] for node in top for alias in node.names}
    assert names <= sys.stdlib_module_names | {WHEEL}  # that one only where it is installed


def test_the_first_cell_goes_straight_on_where_all_is_installed(kernel: Kernel) -> None:
    said = kernel.run(BOOTSTRAP)
    assert said.traceback == ""
    assert said.stdout == "Ready: everything is installed.\n"
    assert (said.stderr, said.displays) == ("", [])


def first_cell(folder: Path, cell: str = BOOTSTRAP, **environment: str) -> tuple[str, Any, Any]:
    """Run the cell where the course is not, with a pip that notes what it is asked for.
    Return the last line said, pip's words and its permission to break the system's packages.
    """
    (folder / "pip.py").write_text(FAKE_PIP)
    seen = folder / "seen.json"
    done = subprocess.run(
        [sys.executable, "-S", "-c", cell],
        env={"SEEN": str(seen), "PYTHONPATH": str(folder), **environment},
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    words, breaks = json.loads(seen.read_text()) if seen.exists() else (None, None)
    return done.stderr.splitlines()[-1], words, breaks


@pytest.mark.parametrize(
    ("source", "beside", "asked"),
    [
        ("{folder}/course.whl", "", "{file}/course.whl"),
        ("git+https://host/x.git", "rclpy_agents_course-9.whl", "git+https://host/x.git"),
        ("", "rclpy_agents_course-0.1.0-py3-none-any.whl", "{file}/{beside}"),
    ],
)
def test_the_first_cell_installs_from_where_it_is_told_or_from_beside_itself(
    tmp_path: Path, source: str, beside: str, asked: str
) -> None:
    if beside:
        (tmp_path / beside).touch()
    told = {"COURSE_SOURCE": source.format(folder=tmp_path)} if source else {}
    said, words, breaks = first_cell(tmp_path, **told)
    assert f"No module named '{WHEEL}'" in said  # this pip installs nothing
    where = asked.format(file=f"file://{tmp_path}", beside=beside)
    assert words[:2] == ["install", "--quiet"]
    assert words[-2:] == [f"rclpy-agents-course[ros,ml] @ {where}", "matplotlib"]
    assert breaks == ("1" if os.getuid() == 0 else None)


def test_without_a_wheel_the_first_cell_asks_for_it(tmp_path: Path) -> None:
    said, words, _ = first_cell(tmp_path)
    assert said.endswith(
        "put rclpy_agents_course-….whl, from your instructor, beside this notebook."
    )
    assert words is None  # no bare name is installed, which anybody could own


PIP_SAYS = {
    "WARNING: Retrying after connection broken by 'NewConnectionError(…)'\n"
    "ERROR: No matching distribution found for numpy": "reaches no network",
    "ERROR: No matching distribution found for pymunk": "package for this system: ERROR",
    "error: subprocess-exited-with-error\nERROR: Failed to build 'pymunk'": "no compiler: ERROR",
    "error: externally-managed-environment": "start Jupyter from a venv",
    "ERROR: [Errno 28] No space left on device": "the disk is full",
    "/usr/bin/python3: No module named pip": "has no pip",
    "ERROR: something else": "pip failed: ERROR: something else",
}


@pytest.mark.parametrize("output", PIP_SAYS)
def test_the_first_cell_says_in_one_sentence_why_not(tmp_path: Path, output: str) -> None:
    (tmp_path / "rclpy_agents_course-0.1.0-py3-none-any.whl").touch()
    said, _, _ = first_cell(tmp_path, SAY=output, EXIT="1")
    assert said.startswith(("NotReady: ", "__main__.NotReady: "))
    assert PIP_SAYS[output] in said


def test_a_notebook_shows_the_sentence_alone(kernel: Kernel, tmp_path: Path) -> None:
    why = BOOTSTRAP.replace("if not (importlib", "if True or (importlib", 1)
    said = kernel.run("import sys; kept = sys.version_info; sys.version_info = (3, 10)\n" + why)
    kernel.run("sys.version_info = kept")
    assert said.traceback.startswith("Not ready: this is Python 3.10; choose a kernel")
    assert said.traceback.count("\n") == 0


# --- the address of a release --------------------------------------------------------------------


def test_a_release_tells_its_notebooks_where_the_wheel_is(tmp_path: Path) -> None:
    address = "https://university.example/course/rclpy_agents_course-0.1.0-py3-none-any.whl"
    source = [line + "\n" for line in BOOTSTRAP.splitlines()]
    notebook = json.dumps({"cells": [{"source": source}]}).encode()
    cells = json.loads(with_address(notebook, address))["cells"]
    _, words, _ = first_cell(tmp_path, "".join(cells[0]["source"]))
    assert words[-2] == f"rclpy-agents-course[ros,ml] @ {address}"


@pytest.mark.parametrize("address", ["course.whl", "https://x/'", 'https://x/"', "https://x/ y"])
def test_what_is_no_address_is_refused(address: str) -> None:
    with pytest.raises(InputError, match="--source"):
        with_address(b"{}", address)


# --- what lacks ----------------------------------------------------------------------------------


def test_requirements_are_those_of_the_project(monkeypatch: pytest.MonkeyPatch) -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    assert len(preparation.required()) == len(extras["dependencies"])
    ros = [one.partition(";")[0] for one in extras["optional-dependencies"]["ros"]]
    assert preparation.required("ros") == ros
    assert preparation.missing() == []
    monkeypatch.setattr(preparation, "COURSE", "a-course-that-is-not-installed")
    assert preparation.missing() == []


SAID_BY_PIP = {
    "error: externally-managed-environment": "this Python belongs to the operating system",
    "/usr/bin/python3: No module named pip": "apt install python3-pip",
    "ERROR: no matching distribution": "    ERROR: no matching distribution",
}


@pytest.mark.parametrize("output", ["", *SAID_BY_PIP])
def test_only_what_lacks_is_installed_and_a_pip_that_fails_is_explained(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str], output: str
) -> None:
    (tmp_path / "pip.py").write_text(FAKE_PIP)
    seen = tmp_path / "seen.json"
    told = {"SEEN": str(seen), "PYTHONPATH": str(tmp_path), "SAY": output}
    for name, value in {**told, "EXIT": str(int(output != ""))}.items():
        monkeypatch.setenv(name, value)
    lacks = ["no-such-thing>=1"]
    monkeypatch.setattr(preparation, "required", lambda extra="": lacks if extra == "ml" else [])
    monkeypatch.setattr(preparation, "adopt", lambda ros: None)
    preparation.prepare_kernel()
    words, _ = json.loads(seen.read_text())
    assert words[0] == "install"
    assert words[-3:] == ["--constraint", str(ROOT / "constraints.txt"), "no-such-thing>=1"]
    out = capsys.readouterr().out
    if output:
        assert out.startswith("Not ready: ")
        assert SAID_BY_PIP[output] in out
        assert "Ready:" not in out
    else:
        assert out == "Installed no-such-thing>=1.\nReady: installed no-such-thing>=1.\n"


def test_nothing_is_installed_over_another_ros(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(RosEnvironment, "find", Mock(side_effect=NoRos("no", "ROS 2 Lyrical")))
    monkeypatch.setattr(preparation, "adopt", lambda ros: None)
    assert preparation.missing() == []
    preparation.prepare_kernel()
    assert "\nROS 2 Lyrical is here; this is Jazzy's portable copy" in capsys.readouterr().out


def test_ros_is_found_by_what_the_kernel_starts(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(sys, "path", [str(tmp_path / "empty folders")])
    monkeypatch.setattr(os, "environ", {"LD_LIBRARY_PATH": "/mine"})
    ros = replace(RosEnvironment.find(), python_path=(tmp_path,), library_path=(tmp_path / "lib",))
    preparation.adopt(ros)
    assert sys.path[-1] == str(tmp_path)
    assert os.environ["LD_LIBRARY_PATH"].split(os.pathsep) == [str(tmp_path / "lib"), "/mine"]
