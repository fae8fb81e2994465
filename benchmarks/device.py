"""CPU or GPU for exercise 8's PyTorch policy: `python benchmarks/device.py`.

Two networks, loaded as `policy_controller.py` loads a `.pt2`: one over the five features of a scan,
and a wider one over all 360 readings and the features. For each device and batch, the time of

- computing alone: rows and answer stay on the device;
- the whole way, as a node pays for it: rows from numpy to the device, computing, the answer back.

CUDA works in the background, so the clock is read only when the device has finished. Without
PyTorch or without a GPU, what can't be measured is named and left out.
"""

import argparse
import importlib.util
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

BATCHES = (1, 8, 64, 512)  # rows
NETWORKS = {5: 64, 365: 512}  # inputs: width of each of the two hidden layers
WARM_UP = 30  # calls that don't count: libraries are loaded, kernels compiled, caches filled
LEAST_CALLS, MOST_CALLS = 50, 5000

Call = Callable[[], object]


@dataclass(frozen=True)
class Row:
    """One network on one device with one batch; all times are of a call."""

    device: str  # cpu or cuda
    inputs: int  # float32 a row
    batch: int  # rows a call
    first: float  # the very first call, the whole way [ms]
    compute: float  # median [ms]
    compute_p99: float  # [ms]
    whole: float  # with transfers, median [ms]
    whole_p99: float  # [ms]


def main(args: Sequence[str] | None = None) -> int:
    """Measure and print."""
    options = _options(args)
    if importlib.util.find_spec("torch") is None:
        print("skipped: PyTorch is not installed; pip install torch")
        return 0
    about, rows = measure(options.batches, options.seconds, options.threads)
    print("\n".join(table(about, rows)))
    return 0


def _options(args: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--batches", type=_count, nargs="+", default=BATCHES, help="rows a call")
    parser.add_argument(
        "--threads", type=_count, help="of the CPU; PyTorch's own choice by default"
    )
    parser.add_argument("--seconds", type=float, default=2.0, help="for each measurement")
    return parser.parse_args(args)


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number from 1 on, got {text!r}")
    return int(text)


# --- measuring ------------------------------------------------------------------------------------


def measure(
    batches: Iterable[int], seconds: float, threads: int | None = None
) -> tuple[dict[str, str], list[Row]]:
    """Return what computed, and the rows of every device that PyTorch can use.

    Parameters
    ----------
    batches
        Rows a call.
    seconds
        For each measurement [s].
    threads
        That compute on the CPU; None: as many as PyTorch likes.
    """
    import torch  # noqa: PLC0415

    if threads is not None:
        torch.set_num_threads(threads)
    devices = ["cpu", *(["cuda"] if torch.cuda.is_available() else [])]
    about = {
        "torch": f"PyTorch {torch.__version__}",
        "cpu": f"{os.cpu_count()} cores, {torch.get_num_threads()} computing, "
        f"load {os.getloadavg()[0]:.1f}",
        "cuda": torch.cuda.get_device_name() if "cuda" in devices else "",
        "features": f"{feature_time():.3f}",
    }
    rows = []
    with torch.inference_mode():
        for inputs, width in NETWORKS.items():
            for device in devices:
                network = load(inputs, width, device)
                rows += [measure_row(network, inputs, n, device, seconds) for n in batches]
    return about, rows


def load(inputs: int, width: int, device: str) -> Any:
    """Return a network as a node gets it: exported, saved, loaded, and moved to the device."""
    import torch  # noqa: PLC0415

    torch.manual_seed(8)  # the weights don't matter, but the same ones each time
    layers = [
        torch.nn.Linear(inputs, width), torch.nn.ReLU(),
        torch.nn.Linear(width, width), torch.nn.ReLU(),
        torch.nn.Linear(width, 1),
    ]  # fmt: skip
    rows = ({0: torch.export.Dim.AUTO},)
    network = torch.nn.Sequential(*layers).eval()
    program = torch.export.export(network, (torch.zeros(2, inputs),), dynamic_shapes=rows)
    with tempfile.TemporaryDirectory(prefix="course-device-") as folder:
        file = Path(folder) / "policy.pt2"
        torch.export.save(program, file)
        return torch.export.load(file).module().to(device)


def measure_row(network: Any, inputs: int, batch: int, device: str, seconds: float) -> Row:
    """Measure one network with one batch."""
    import torch  # noqa: PLC0415

    given = np.random.default_rng(batch).uniform(0.15, 12.0, (batch, inputs)).astype(np.float32)
    there = torch.from_numpy(given).to(device)
    finished = torch.cuda.synchronize if device == "cuda" else _nothing

    def compute() -> None:
        network(there)
        finished()

    def whole() -> None:
        network(torch.from_numpy(given).to(device)).cpu().numpy()  # .cpu() waits for the answer

    first = time_call(whole, finished)
    answers = timed(compute, finished, seconds), timed(whole, finished, seconds)
    (alone, alone_p99), (way, way_p99) = (np.percentile(each, (50, 99)) for each in answers)
    return Row(
        device, inputs, batch, first, float(alone), float(alone_p99), float(way), float(way_p99)
    )


def timed(call: Call, finished: Call, seconds: float) -> list[float]:
    """Return the times of calls after a warm-up [ms]."""
    for _ in range(WARM_UP):
        call()
    times: list[float] = []
    end = time.perf_counter() + seconds
    while len(times) < LEAST_CALLS or (time.perf_counter() < end and len(times) < MOST_CALLS):
        times.append(time_call(call, finished))
    return times


def time_call(call: Call, finished: Call) -> float:
    """Return the time of one call that begins with an idle device [ms]."""
    finished()
    begin = time.perf_counter_ns()
    call()
    return (time.perf_counter_ns() - begin) / 1e6


def feature_time(calls: int = 200) -> float:
    """Return the median time of making the five features of one scan [ms]."""
    from grader.models.features import features  # noqa: PLC0415
    from sim.lidar import PROFILES  # noqa: PLC0415

    lidar = PROFILES["default"]
    ranges = np.random.default_rng(1).uniform(0.2, 9.0, (1, lidar.beams)).astype(np.float32)
    angles = np.degrees(lidar.angles)
    times = [
        time_call(lambda: features(ranges, angles, lidar.range_min, lidar.range_max), _nothing)
        for _ in range(calls)
    ]
    return float(np.median(times))


def _nothing() -> None:
    """Wait for nothing: a CPU has finished when its call returns."""


# --- showing --------------------------------------------------------------------------------------


def table(about: dict[str, str], rows: Sequence[Row]) -> list[str]:
    """Return the lines of the table; a device that was not there says so."""
    lines = [
        f"{about['torch']}; CPU: {about['cpu']}; GPU: {about['cuda'] or 'none'}",
        f"five features of one scan, numpy: {about['features']} [ms]",
    ]
    for inputs in dict.fromkeys(row.inputs for row in rows):
        width = NETWORKS.get(inputs, 0)
        lines += [
            "",
            f"{inputs} inputs, two hidden layers of {width}; times of a call [ms]",
            f"{'device':8}{'batch':>6}{'compute':>10}{'p99':>9}{'whole way':>11}{'p99':>9}"
            f"{'a row':>10}{'first':>10}",
        ]
        lines += [
            f"{row.device:8}{row.batch:6}{row.compute:10.3f}{row.compute_p99:9.3f}"
            f"{row.whole:11.3f}{row.whole_p99:9.3f}{row.whole / row.batch:10.4f}{row.first:10.2f}"
            for row in rows
            if row.inputs == inputs
        ]
        if not any(row.device == "cuda" and row.inputs == inputs for row in rows):
            lines.append("cuda    skipped: PyTorch sees no CUDA device on this machine")
    return lines


if __name__ == "__main__":
    sys.exit(main())
