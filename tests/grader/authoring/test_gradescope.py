"""The zip for Gradescope: what is in it, for whom, and that its scripts are sound."""

import re
import stat
import subprocess
import zipfile
from pathlib import Path

import msgspec
import pytest

from grader.authoring.gradescope import setup, write_autograder
from grader.classroom.autograder import SECRET, SETTINGS, Settings
from grader.errors import InputError

SLUGS = ("goal_seeking", "live_parameters")


@pytest.fixture(scope="module")
def secret(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("secret") / "mine"
    file.write_text("0123456789abcdef" * 2, "utf-8")
    return file


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory, secret: Path) -> Path:
    folder = tmp_path_factory.mktemp("gradescope") / "upload"
    return write_autograder(folder, exercises=SLUGS, hide=["worlds"], secret=secret)


def test_it_has_the_judge_and_no_solution_or_exercise_of_another_week(made: Path) -> None:
    with zipfile.ZipFile(made) as archive:
        names = set(archive.namelist())

    assert {"setup.sh", "run_autograder", SETTINGS, SECRET} <= names
    assert {"course/grader/classroom/autograder.py", "course/pyproject.toml"} <= names
    assert "course/exercises/goal_seeking/exercise.toml" in names
    assert not [name for name in names if "solutions" in name or "exercises/slow_model/" in name]


def test_scripts_may_be_run_and_secrets_are_the_owners(made: Path) -> None:
    with zipfile.ZipFile(made) as archive:
        modes = {each.filename: each.external_attr >> 16 for each in archive.infolist()}

    assert {modes["setup.sh"], modes["run_autograder"]} == {stat.S_IFREG | 0o755}
    assert {modes[SETTINGS], modes[SECRET]} == {stat.S_IFREG | 0o600}
    assert stat.S_IMODE(made.stat().st_mode) == 0o600


def test_what_is_written_is_what_the_autograder_reads(made: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(made) as archive:
        archive.extract(SETTINGS, tmp_path)

    settings = msgspec.json.decode((tmp_path / SETTINGS).read_bytes(), type=Settings)

    assert settings == Settings(SLUGS, False, ("worlds",))


@pytest.mark.parametrize("deep", [False, True])
def test_the_scripts_are_bash(deep: bool, tmp_path: Path) -> None:
    script = tmp_path / "setup.sh"
    script.write_text(setup(deep=deep), "utf-8")

    assert subprocess.run(["bash", "-n", str(script)], check=False).returncode == 0
    assert ("download.pytorch.org" in script.read_text("utf-8")) == deep
    assert not re.search(r"(?<!\$)\{(torch|extras)\}", script.read_text("utf-8"))


def test_a_folder_with_something_in_it_is_refused(tmp_path: Path) -> None:
    (tmp_path / "mine").write_text("x")

    with pytest.raises(InputError, match="expected a new or empty folder"):
        write_autograder(tmp_path, exercises=SLUGS)
