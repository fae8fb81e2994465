"""The real thing: a few gradings, killed, resumed, and on a cluster, come out the same."""

import contextlib
import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from grader.claims.mutants import find_mutant
from grader.classroom.queue.store import Store
from grader.classroom.row import StoredResult
from grader.course.exercises import find_exercise

pytestmark = pytest.mark.long

SLUG, FILE = "trend_memory", "trend_agent.py"
COURSE = [sys.executable, "-m", "grader.cli", "autograde"]
DASK = [sys.executable, "-m", "dask"]
SOLUTIONS = Path(__file__).resolve().parents[3] / "solutions" / SLUG
EVIL = """\
import os, signal
os.kill(-1, signal.SIGKILL)
"""
MOMENTS = (1, 3)  # after so many lines it is killed

Results = dict[str, str]


@pytest.fixture(scope="module")
def handed_in(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("handed in")
    mutant = find_mutant(find_exercise(SLUG), "afraid_of_leaving")
    texts = {
        "Ünal, Zoë": (SOLUTIONS / FILE).read_text(),
        "bob": mutant.text,
        "cut off": "def main(:\n",
        "evil": EVIL,
    }
    for name, text in texts.items():
        (folder / name).mkdir()
        (folder / name / FILE).write_text(text)
    (folder / "empty").mkdir()
    (folder / "misnamed").mkdir()
    (folder / "misnamed" / "robot.py").write_text("# whose exercise is this?\n")
    return folder


@pytest.fixture(scope="module")
def undisturbed(handed_in: Path, tmp_path_factory: pytest.TempPathFactory) -> Results:
    out = tmp_path_factory.mktemp("undisturbed")
    done = subprocess.run(_command(handed_in, out), check=False, stdout=subprocess.DEVNULL)
    assert done.returncode == 1  # one is held: no exercise has such a file
    return _results(out)


def test_what_the_class_came_to(undisturbed: Results) -> None:
    states = {name: json.loads(text)[4] for name, text in undisturbed.items()}
    scores = {name: json.loads(text)[5] for name, text in undisturbed.items()}

    assert states == {
        "Ünal, Zoë": "graded", "bob": "graded", "cut off": "graded", "evil": "graded",
        "empty": "not handed in", "misnamed": "held",
    }  # fmt: skip
    assert scores["Ünal, Zoë"] == 100
    assert scores["cut off"] == scores["evil"] == 0
    assert 0 < scores["bob"] < 100


def test_killed_twice_and_resumed(handed_in: Path, undisturbed: Results, tmp_path: Path) -> None:
    command = _command(handed_in, tmp_path, "--workers", "2")
    for lines in MOMENTS:
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as batch:
            assert batch.stdout is not None
            for _ in range(lines - _graded(tmp_path)):
                batch.stdout.readline()
            batch.send_signal(signal.SIGKILL)
        subprocess.run(
            [*COURSE[:-1], "marks", "score", str(tmp_path), str(10 + lines), "--student", "bob",
             "--why", f"killed after {lines} lines"],
            check=True, stdout=subprocess.DEVNULL,
        )  # fmt: skip
    assert 0 < _graded(tmp_path) < 4
    subprocess.run(command, check=False, stdout=subprocess.DEVNULL)

    assert _results(tmp_path) == undisturbed
    assert not (tmp_path / "recordings" / ".part").exists()
    assert len(list((tmp_path / "recordings").glob("*/*"))) == 4
    assert "bob,,,,trend_memory,graded,13,100" in (tmp_path / "scores.csv").read_text("utf-8-sig")
    with Store(tmp_path / "store.sqlite") as store:
        assert [entry.number for entry in store.entries()] == [1, 2]


def test_sigterm_ends_it_as_ctrl_c_does(
    handed_in: Path, undisturbed: Results, tmp_path: Path
) -> None:
    command, pipe = _command(handed_in, tmp_path), subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as batch:
        assert batch.stdout is not None
        batch.stdout.readline()
        batch.terminate()
        said, complaint = batch.communicate()
    assert (batch.returncode, complaint.strip()) == (2, "course: interrupted")
    assert "interrupted: writing what is graded" in said
    assert (tmp_path / "scores.csv").is_file()
    assert sorted(path.name for path in tmp_path.glob(".*")) == [".lock"]
    subprocess.run(command, check=False, stdout=subprocess.DEVNULL)
    assert _results(tmp_path) == undisturbed


def test_on_a_cluster_that_loses_a_worker(
    handed_in: Path, undisturbed: Results, tmp_path: Path
) -> None:
    pytest.importorskip("distributed", reason="needs the extra `cluster`")
    file, out = tmp_path / "scheduler.json", tmp_path / "out"
    options = ("--host", "127.0.0.1", "--no-dashboard", "--scheduler-file", str(file))
    with _process("scheduler", "--port", "0", *options, ready="Scheduler at") as _:
        options = ("--nthreads", "1", "--no-nanny", "--no-dashboard")
        join = ("worker", "--scheduler-file", str(file), *options)
        with _process(*join, ready="Registered to"), _process(*join, ready="Registered") as second:
            command = _command(handed_in, out, "--dask", str(file))
            with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as batch:
                assert batch.stdout is not None
                batch.stdout.readline()
                second.kill()
                batch.stdout.read()

    assert batch.returncode == 1
    assert _results(out) == undisturbed
    assert len(list((out / "recordings").glob("*/*/*/metadata.yaml"))) > 4


def _command(handed_in: Path, out: Path, *options: str) -> list[str]:
    begin = [*COURSE, str(handed_in), "--out", str(out), "--exercise", SLUG]
    return [*begin, "--canaries", "0", "--trust", *options]


def _graded(out: Path) -> int:
    if not (out / "store.sqlite").exists():
        return 0
    with Store(out / "store.sqlite") as store:
        return sum(result.state == "graded" for result in store.results())


def _results(out: Path) -> Results:
    with Store(out / "store.sqlite") as store:
        return {result.student: json.dumps(stable(result)) for result in store.results()}


def stable(result: StoredResult) -> tuple[object, ...]:
    """Return the part of a result that is the same whenever and wherever it is graded."""
    known = (result.student, result.exercise, result.file_names, result.input_hash, result.state)
    if result.grading is None:
        return (*known, result.problem)
    checks = [(c["id"], c["outcome"], c["points"]) for c in result.grading["checks"]]
    runs = [(r["scenario"], r["seed"], r["outcome"]) for r in result.grading["recordings"]]
    return (*known, result.grading["score"], checks, runs)


@contextlib.contextmanager
def _process(*command: str, ready: str) -> Iterator[subprocess.Popen[str]]:
    """Run a part of a cluster until the block ends; wait until it says that it is ready."""
    with subprocess.Popen([*DASK, *command], stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        try:
            for line in process.stderr:
                if ready in line:
                    break
            yield process
        finally:
            process.kill()
