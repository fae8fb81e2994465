"""`dataset` and `train`: make training data, and run a training script on it."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from grader.errors import InputError
from grader.models.dataset import Dataset, baselines, make_dataset
from grader.models.scans import PROFILE
from grader.notebook.child import environment
from grader.notebook.program import run
from grader.notebook.session import SESSION
from grader.notebook.show import Progress, preformatted, tell
from grader.report.facts import plain

if TYPE_CHECKING:
    from numpy.typing import NDArray

MOST_OUTPUT = 20_000  # [characters] of a script's output that are shown, the last ones


@dataclass(frozen=True, eq=False, repr=False)
class NotebookDataset:
    """Labelled scans, as in the file."""

    file: Path
    made: Dataset
    angles: NDArray[np.float64]  # (360,) [rad], positive to the left
    range_min: float = PROFILE.range_min  # [m]
    range_max: float = PROFILE.range_max  # [m]

    @property
    def ranges(self) -> NDArray[np.float32]:
        """(scans, 360) [m]."""
        return self.made.ranges

    @property
    def speed(self) -> NDArray[np.float64]:
        """(scans,) [m/s]."""
        return self.made.speed

    @property
    def room(self) -> NDArray[np.int64]:
        """(scans,) in which of the rooms each was made."""
        return self.made.room

    def scan(self, index: int) -> tuple[NDArray[np.float32], float, float, float, float]:
        """Return one scan as `show_scan` and `show_features` take it."""
        return (
            self.ranges[index], PROFILE.angle_min, PROFILE.angle_increment,
            self.range_min, self.range_max,
        )  # fmt: skip

    def __repr__(self) -> str:
        """Describe the data, as `course dataset` does."""
        return f"{self.file}: {baselines(self.made)}"


def write_dataset(file: Path, *, scans: int, seed: int) -> NotebookDataset:
    """See `grader.notebook.dataset`.

    Raises InputError: a number is out of range, or the file has another suffix.
    """
    if file.suffix != ".npz":
        raise InputError(f"{file}: expected a name that ends in .npz, such as train.npz")
    if not 100 <= scans <= 100_000:
        raise InputError(f"scans={scans}: expected 100 to 100000")
    if seed < 0:
        raise InputError(f"seed={seed}: expected 0 or more")
    made = make_dataset(scans, seed)
    made.save(file)
    return NotebookDataset(file, made, PROFILE.angles)


def train_model(script: Path, *, data: Path, out: Path, onnx: Path) -> bool:
    """See `grader.notebook.train`."""
    try:
        SESSION.usable(script, [script.name])
    except InputError as error:
        tell(f"Not trained: {error}")
        return False
    if not data.is_file():
        tell(repr(write_dataset(data, scans=2000, seed=1)))
    for model in (out, onnx):
        model.unlink(missing_ok=True)  # an old one would be taken for this script's
    paths = ("--data", str(data), "--out", str(out), "--onnx", str(onnx))
    command = [sys.executable, "-u", str(script.resolve()), *paths]
    bar = Progress(f"{script.name} trains")
    begin = time.monotonic()
    try:
        code, said = run(command, bar, environment(), plain)
    except KeyboardInterrupt:
        bar.say("Not trained: stopped, because you interrupted the kernel. Run the cell again.")
        return False
    lines = [plain(line) for line in said[-MOST_OUTPUT:].strip().split("\n") if said.strip()]
    lines += _outcome(script, code, time.monotonic() - begin, (out, onnx))
    text = "\n".join(lines)
    bar.end({"text/plain": text, "text/html": preformatted(text)})
    return code == 0 and out.is_file() and onnx.is_file()


def _outcome(script: Path, code: int, seconds: float, models: tuple[Path, Path]) -> list[str]:
    if code:
        how = f"signal {-code}" if code < 0 else f"exit code {code}"
        return [f"Not trained: {script.name} failed after {seconds:.1f} s ({how})"]
    lines = [f"{script.name} took {seconds:.1f} s"]
    for model in models:
        there = model.is_file()
        size = f"{model.stat().st_size:,} bytes" if there else "was not written"
        lines.append(f"  {'✓' if there else '✗'} {model}: {size}")
    return lines
