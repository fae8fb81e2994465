"""A Python that finds its own libraries through LD_LIBRARY_PATH only can have hosts."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

from grader.course.exercises import ROOT
from grader.link.interpreter import left_out, library_folders, with_needs

SHARED = bool(sysconfig.get_config_var("Py_ENABLE_SHARED"))
LAUNCHER = """
int own(void);
int Py_BytesMain(int count, char **words);
int main(int count, char **words) { return own() + Py_BytesMain(count, words); }
"""


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


@pytest.mark.long
@pytest.mark.skipif(
    not SHARED or not shutil.which("gcc"), reason="needs a shared libpython and gcc"
)
def test_a_relocated_python_grades(tmp_path: Path) -> None:
    """One of its libraries is found through LD_LIBRARY_PATH alone, as an HPC module's."""
    own = tmp_path / "own"
    own.mkdir()
    venv = tmp_path / "venv"
    (venv / "bin").mkdir(parents=True)
    shutil.copy(Path(sys.prefix, "pyvenv.cfg"), venv)
    (venv / "lib").symlink_to(Path(sys.prefix, "lib"))
    (tmp_path / "own.c").write_text("int own(void) { return 0; }\n")
    (tmp_path / "main.c").write_text(LAUNCHER)
    library = str(sysconfig.get_config_var("LIBDIR"))
    name = str(sysconfig.get_config_var("LDLIBRARY")).removeprefix("lib").removesuffix(".so")
    python = venv / "bin" / "python"
    for command in (
        ["-shared", "-o", str(own / "libown.so"), str(tmp_path / "own.c")],
        ["-o", str(python), str(tmp_path / "main.c"), f"-L{own}", "-lown", f"-L{library}",
         f"-Wl,-rpath,{library}", f"-l{name}"],
    ):  # fmt: skip
        subprocess.run(["gcc", *command], check=True)
    bare = {"PATH": "/usr/bin:/bin", "HOME": str(tmp_path)}
    assert subprocess.run([python, "-V"], env=bare, capture_output=True, check=False).returncode
    environ = bare | path_of("/usr/lib", own)
    solution = ROOT / "solutions/obstacle_avoidance/obstacle_avoidance_agent.py"

    done = subprocess.run(
        [python, "-m", "grader.cli", "grade", "1", str(solution), "--only", "wiring"],
        env=environ, capture_output=True, text=True, check=False, cwd=ROOT,
    )  # fmt: skip

    assert "no host" not in done.stderr, done.stderr
    assert "✓ pass" in done.stdout, done.stdout + done.stderr
