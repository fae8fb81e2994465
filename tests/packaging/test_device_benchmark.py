"""benchmarks/device.py: what it measures, and what it says where it can't. Never how fast."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from grader.course.exercises import ROOT

PROGRAM = ROOT / "benchmarks" / "device.py"
SKIPPED = "cuda    skipped: PyTorch sees no CUDA device on this machine"
ROW = {"inputs": 5, "calls": 50, "first": 30.0, "compute": 0.05, "compute_p99": 0.06,
       "whole": 0.06, "whole_p99": 0.07}  # fmt: skip
KEPT = {
    "torch": "PyTorch 2.0", "cpu": "2 cores", "cuda": "a GPU", "features": "0.04",
    "rows": [{**ROW, "device": device, "batch": n} for device in ("cpu", "cuda") for n in (1, 8)],
}  # fmt: skip


def measure(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, str(PROGRAM), *arguments],
        cwd=ROOT, capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip


@pytest.fixture
def kept(tmp_path: Path) -> Path:
    file = tmp_path / "kept.json"
    file.write_text(json.dumps(KEPT), "utf-8")
    return file


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, dict[str, Any]]:
    """The table and the numbers of a short measurement, on every device that is there."""
    pytest.importorskip("torch", reason="PyTorch is not installed: make test-deep")
    file = tmp_path_factory.mktemp("device") / "device.json"
    done = measure(
        "--batches", "1", "8", "--seconds", "0.01", "--threads", "1", "--keep", str(file)
    )
    assert done.returncode == 0, done.stderr
    return done.stdout, json.loads(file.read_text("utf-8"))


@pytest.mark.deep
def test_the_cpu_is_measured(measured: tuple[str, dict[str, Any]]) -> None:
    rows = [row for row in measured[1]["rows"] if row["device"] == "cpu"]
    assert [(row["inputs"], row["batch"]) for row in rows] == [(5, 1), (5, 8), (365, 1), (365, 8)]
    for row in rows:
        assert row["calls"] >= 50
        assert 0 < row["compute"] <= row["compute_p99"]
        assert 0 < row["whole"] <= row["whole_p99"]
        assert row["first"] > 0


@pytest.mark.deep
def test_a_gpu_is_measured_or_named(measured: tuple[str, dict[str, Any]]) -> None:
    import torch  # noqa: PLC0415

    table, numbers = measured
    if not torch.cuda.is_available():
        assert table.count(SKIPPED) == 2
        pytest.skip("PyTorch sees no CUDA device on this machine")
    rows = [row for row in numbers["rows"] if row["device"] == "cuda"]
    assert len(rows) == 4
    assert all(row["compute"] > 0 and row["whole"] > 0 for row in rows)
    assert "skipped" not in table


def test_without_pytorch_it_says_so() -> None:
    if importlib.util.find_spec("torch") is not None:
        pytest.skip("PyTorch is installed here")
    done = measure()
    assert done.returncode == 0
    assert done.stdout.startswith("skipped: PyTorch is not installed")


def test_what_was_measured_elsewhere_is_shown_and_drawn(kept: Path, tmp_path: Path) -> None:
    drawing = tmp_path / "device.svg"
    done = measure("--from", str(kept), "--plot", str(drawing))
    assert done.returncode == 0, done.stderr
    assert "GPU: a GPU" in done.stdout
    assert done.stdout.count("\ncuda ") == 2
    if importlib.util.find_spec("matplotlib") is None:
        assert "plot skipped" in done.stdout
        pytest.skip("matplotlib is not installed")
    assert "cuda, without transfers" in drawing.read_text("utf-8")


@pytest.mark.parametrize("text", ["", "{}", '{"rows": []}', '{"rows": [{"device": "cpu"}]}'])
def test_a_file_of_something_else_is_refused(tmp_path: Path, text: str) -> None:
    file = tmp_path / "other.json"
    file.write_text(text, "utf-8")
    done = measure("--from", str(file))
    assert done.returncode == 1
    assert "expected a file that --keep wrote" in done.stderr


def test_a_batch_of_no_rows_is_refused() -> None:
    done = measure("--batches", "0")
    assert done.returncode == 2
    assert "expected a whole number from 1 on, got '0'" in done.stderr
