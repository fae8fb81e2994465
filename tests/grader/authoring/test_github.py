"""GitHub Classroom's template repository, and the container that a release comes with."""

import base64
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from grader.authoring import github
from grader.authoring.release import release
from grader.course.exercises import find_exercise

SIX, TEN = find_exercise("6"), find_exercise("10")


@pytest.fixture(scope="module")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("template") / "course"
    chosen = [SIX.slug, TEN.slug]
    release(folder, exercises=chosen, more=github.files([SIX, TEN]))
    return folder


@pytest.fixture(scope="module")
def job(template: Path) -> dict[str, Any]:
    text = (template / ".github" / "workflows" / "classroom.yml").read_text("utf-8")
    found: dict[str, Any] = yaml.safe_load(text)["jobs"]["grade"]
    return found


def test_each_exercise_has_a_step_that_the_reporter_reads(job: dict[str, Any]) -> None:
    steps = {step["id"]: step for step in job["steps"] if "id" in step}
    reporter = job["steps"][-1]

    assert set(steps) == {"exercise-10", "exercise-6"}
    assert reporter["with"]["runners"].split(",") == list(steps)
    for name in steps:  # as the reporter looks for them
        value = reporter["env"][f"{name.upper()}_RESULTS"]
        assert value == f"${{{{ steps.{name}.outputs.result }}}}"


def step_of(template: Path, job: dict[str, Any], name: str) -> dict[str, Any]:
    """Run a step of the workflow; return the result that it gives."""
    (step,) = [step for step in job["steps"] if step.get("id") == name]
    command = step["run"].replace("python ", f"{sys.executable} ", 1)
    output = template / "output"
    output.write_text("")
    subprocess.run(
        ["bash", "-e", "-c", command], cwd=template, check=True, capture_output=True,
        env={"GITHUB_OUTPUT": str(output), "PATH": "/usr/bin:/bin"},
    )  # fmt: skip
    key, _, value = output.read_text("utf-8").partition("=")
    assert key == "result"
    found: dict[str, Any] = json.loads(base64.b64decode(value))
    return found


@pytest.mark.parametrize(
    ("place", "status", "points"),
    [
        pytest.param(TEN.folder, "fail", 0, id="skeleton", marks=pytest.mark.long),
        pytest.param(TEN.solutions, "pass", 100, id="reference"),
    ],
)
def test_a_push_is_graded(
    template: Path, job: dict[str, Any], place: Path, status: str, points: int
) -> None:
    (template / TEN.files[0]).write_bytes((place / TEN.files[0]).read_bytes())
    found = step_of(template, job, "exercise-10")
    assert set(found) == {"version", "status", "max_score", "tests"}
    assert found["max_score"] == 100
    assert (found["status"], sum(test["score"] for test in found["tests"])) == (status, points)
    assert {test["status"] for test in found["tests"]} == {status}


def test_a_release_has_the_container(template: Path) -> None:
    about = json.loads((template / ".devcontainer" / "devcontainer.json").read_text("utf-8"))
    file = (template / ".devcontainer" / about["build"]["dockerfile"]).resolve()

    assert file == (template / "Dockerfile").resolve()
    assert about["remoteUser"] == "jovyan"
    assert ".github" not in (template / ".dockerignore").read_text("utf-8").splitlines()
