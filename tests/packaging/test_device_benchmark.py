"""benchmarks/device.py: what it measures, and what it says where it can't. Never how fast."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from grader.course.exercises import ROOT

ROW = {"inputs": 5, "calls": 50, "first": 30.0, "compute": 0.05, "compute_p99": 0.06,
       "whole": 0.06, "whole_p99": 0.07}  # fmt: skip
KEPT = {
    "torch": "PyTorch 2.0", "cpu": "2 cores", "cuda": "a GPU", "features": "0.04",
    "rows": [{**ROW, "device": device, "batch": n} for device in ("cpu", "cuda") for n in (1, 8)],
}  # fmt: skip


def measure(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, str(ROOT / "benchmarks" / "device.py"), *map(str, arguments)],
        cwd=ROOT, capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip


@pytest.mark.deep
def test_every_device_is_measured_or_named(tmp_path: Path) -> None:
    torch = pytest.importorskip("torch", reason="PyTorch is not installed: make test-deep")
    file = tmp_path / "device.json"
    done = measure("--batches", 1, 8, "--seconds", 0.01, "--threads", 1, "--keep", file)
    assert done.returncode == 0, done.stderr
    rows = json.loads(file.read_text("utf-8"))["rows"]
    devices = ("cpu", "cuda") if torch.cuda.is_available() else ("cpu",)
    assert [(row["device"], row["inputs"], row["batch"]) for row in rows] == [
        (device, inputs, batch) for device in devices for inputs in (5, 365) for batch in (1, 8)
    ]
    assert all(row["calls"] >= 50 and 0 < row["compute"] <= row["compute_p99"] for row in rows)
    assert ("PyTorch sees no CUDA device on this machine" in done.stdout) == ("cuda" not in devices)


def test_what_was_measured_elsewhere_is_shown_and_drawn(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    kept, drawing = tmp_path / "kept.json", tmp_path / "device.svg"
    kept.write_text(json.dumps(KEPT), "utf-8")
    done = measure("--from", kept, "--plot", drawing)
    assert done.returncode == 0, done.stderr
    assert "GPU: a GPU" in done.stdout
    assert "cuda, without transfers" in drawing.read_text("utf-8")
    kept.write_text('{"rows": [{"device": "cpu"}]}', "utf-8")
    assert "expected a file that --keep wrote" in measure("--from", kept).stderr
