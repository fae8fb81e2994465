"""From a notebook's first cell to its first check, on this machine's own Python with nothing in it.

The kernel runs in an overlay of /usr that ends with it, so pip puts wheels where it puts them on
Debian, Ubuntu and Colab. It needs root and a network, and downloads some hundred megabytes: `make
notebooks` runs it.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import kernels
import pytest
from nbgrader_kit import FULL

from grader.course.exercises import ROOT, find_exercise
from grader.notebook.bootstrap import BOOTSTRAP

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not FULL, reason="downloads much: `make notebooks` runs it"),
]

PYTHON = "/usr/bin/python3"
PATIENCE = 300.0  # [s] with all downloads
OVERLAY = """\
set -e
mount --make-rprivate /
mount -t tmpfs tmpfs "$0"
mkdir "$0/upper" "$0/work"
mount -t overlay overlay -o "lowerdir=/usr,upperdir=$0/upper,workdir=$0/work" /usr
"""
KERNEL = f"{OVERLAY}{PYTHON} -m pip install --quiet --break-system-packages ipykernel\n"
NO_COMPILER = 'rm -f /usr/bin/*gcc* /usr/bin/*g++* /usr/bin/cc /usr/bin/c++\nexec "$@"\n'
FOREIGN = ("PYTHON", "VIRTUAL_ENV", "LD_LIBRARY_PATH", "AMENT", "ROS", "_ROS", "JUPYTER", "COURSE")


@pytest.fixture
def layers(tmp_path: Path) -> Iterator[Path]:
    """A folder for the overlay's layers; skips where there can be none."""
    folder = tmp_path / "layers"
    folder.mkdir()
    asked = f'{OVERLAY}exec {PYTHON} -c "import sys, pip; assert (3, 11) <= sys.version_info"'
    tried = subprocess.run(
        ["unshare", "--mount", "bash", "-c", asked, str(folder)],
        cwd=tmp_path, env=bare(), capture_output=True, text=True, check=False,
    )  # fmt: skip
    if os.getuid() != 0 or tried.returncode:
        pytest.skip(f"no overlay over /usr, or no Python of 3.11 with pip: {tried.stderr.strip()}")
    yield folder


@pytest.fixture
def notebook(tmp_path: Path) -> Path:
    """The folder of a notebook with the course's wheel in it."""
    folder = tmp_path / "notebook"
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir"]
    subprocess.run([*pip, str(folder), str(ROOT)], check=True)
    return folder


def bare() -> dict[str, str]:
    """Return this process's environment without what belongs to its own Python."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith(FOREIGN)}
    return {**kept, "PATH": "/usr/local/bin:/usr/bin:/bin", "PIP_NO_CACHE_DIR": "1"}


def test_a_bare_python_grades_a_node(
    layers: Path, notebook: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernels, "LIMIT", PATIENCE)
    (file,) = find_exercise("1").files
    node = (find_exercise("1").solutions / file).read_text("utf-8")
    argv = ["unshare", "--mount", "bash", "-c", KERNEL + NO_COMPILER, str(layers), PYTHON]
    with kernels.started(notebook, [*argv, "-m", "ipykernel_launcher"], **bare()) as kernel:
        first = kernel.run(BOOTSTRAP)
        assert "Ready: " in first.stdout, first
        kernels.save(kernel, file, node)
        graded = kernel.run('report = check("1")\nprint(report.score, report.max_score)')
        assert "100 100" in graded.stdout, graded
