"""Whoever needs the notebooks makes them: an image and a dev container do, and nbgrader says so."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest
from traitlets.config import PyFileConfigLoader

from grader.course.exercises import ROOT
from grader.notebook.build import all_notebooks

DOCKERFILE = (ROOT / "Dockerfile").read_text("utf-8")
STEP = re.search(r"WORKDIR \$\{HOME\}\nRUN (.+)", DOCKERFILE)


def run_step(folder: Path) -> None:
    """Run the step of the Dockerfile that makes the notebooks, as the image's shell would."""
    assert STEP is not None
    path = f"{Path(sys.executable).parent}:/usr/bin:/bin"
    subprocess.run(["sh", "-c", STEP[1]], cwd=folder, env={**os.environ, "PATH": path}, check=True)


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """What of a checkout gets into an image."""
    lines = (ROOT / ".dockerignore").read_text("utf-8").split()
    outside = [f":!{line}" for line in lines if not line.startswith((".", "**"))]
    assert {":!solutions", ":!notebooks/source"} <= set(outside)
    listed = ["git", "ls-files", "-z", "--", ".", *outside]
    try:
        done = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("no git, or no checkout")
    for name in filter(None, done.stdout.split("\0")):
        if (ROOT / name).is_file():
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, tmp_path / name)
    return tmp_path


def test_an_image_of_a_checkout_has_the_notebooks_without_solutions(checkout: Path) -> None:
    run_step(checkout)
    made = {path.stem: path for path in (checkout / "notebooks/source").rglob("*.ipynb")}
    assert sorted(made) == all_notebooks()
    for path in made.values():
        nbformat.validate(nbformat.read(path, as_version=4))
        assert "BEGIN SOLUTION" not in path.read_text("utf-8")


def test_an_image_of_a_release_has_them_already(tmp_path: Path) -> None:
    (tmp_path / "notebooks").mkdir()
    run_step(tmp_path)
    assert not list((tmp_path / "notebooks").iterdir())


def test_a_dev_container_makes_them() -> None:
    about = json.loads((ROOT / ".devcontainer/devcontainer.json").read_text("utf-8"))
    assert STEP is not None
    assert f"&& {{ {STEP[1]}; }} &&" in about["postCreateCommand"]


def test_an_instructor_reads_what_to_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Not an empty list, nor last year's notebooks."""
    folder = tmp_path / "notebooks"
    made, text = folder / "source/01_loop/01_loop.ipynb", folder / "text/01_loop/01_loop.md"
    for path in (made, text):
        path.parent.mkdir(parents=True)
    shutil.copy(ROOT / "notebooks/nbgrader_config.py", folder)
    config = PyFileConfigLoader("nbgrader_config.py", str(folder))
    with pytest.raises(SystemExit, match=r"not made yet\. `make assignments`"):
        config.load_config()
    made.touch()
    text.touch()
    os.utime(text, (1e9, 1e9))
    assert "GenerateAssignment" in config.load_config()
    assert capsys.readouterr().err == ""
    os.utime(text, (4e9, 4e9))
    config.load_config()
    assert "older than what it is made from. `make assignments`" in capsys.readouterr().err
