"""Plots of scans: what is drawn is what the scan says, left is left, and axes have units."""

import math
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from kernels import Kernel

matplotlib = pytest.importorskip("matplotlib", reason="matplotlib is not installed")
matplotlib.use("agg")

from matplotlib import pyplot as plt  # noqa: E402

from grader.errors import InputError  # noqa: E402
from grader.models.features import scan_features  # noqa: E402
from grader.notebook import show_features, show_left_right, show_scan  # noqa: E402
from grader.notebook.plots import as_scan  # noqa: E402

RANGES = np.full(360, 4.0)
SHOWS = (show_scan, show_features, show_left_right)


@pytest.fixture(autouse=True)
def _close() -> Any:
    yield
    plt.close("all")


def points(axes: Any) -> np.ndarray:
    """(n, 2) of what is drawn as a distance: how far left, how far ahead [m]."""
    lines = [line for line in axes.lines if line.get_label().endswith("distances")]
    return np.column_stack(lines[0].get_data())


@pytest.mark.parametrize("show", SHOWS)
def test_axes_have_names_and_units_also_those_that_are_given(show: Any) -> None:
    _, given = plt.subplots()
    axes = show("demo_wall", ax=given)
    assert axes is given
    assert len(plt.get_fignums()) == 1
    assert axes.get_xlabel().count("[") == 1
    assert axes.get_ylabel().endswith("[m]")
    assert axes.get_title() == "A wall ahead, 0.01 s"


@pytest.mark.parametrize(
    ("degrees", "left", "ahead"), [(0, 0.0, 2.0), (90, 2.0, 0.0), (-90, -2.0, 0.0)]
)
def test_left_is_left_and_ahead_is_up(degrees: float, left: float, ahead: float) -> None:
    ranges = np.full(360, math.inf)  # of the default lidar, with nothing but one thing
    ranges[round(degrees) + 180] = 2.0
    axes = show_scan(ranges)
    np.testing.assert_allclose(points(axes), [[left, ahead]], atol=1e-6)
    first, last = axes.get_xlim()
    assert first > 0 > last  # the horizontal axis grows to the left
    low, high = axes.get_ylim()
    assert low < 0 < high


def test_what_is_no_distance_is_counted_and_not_drawn_as_one() -> None:
    ranges = np.full(360, 3.0)
    ranges[:10] = math.nan
    ranges[10:30] = math.inf
    ranges[30:33] = -math.inf
    ranges[33:35] = 99.0
    axes = show_scan((ranges, -math.pi, math.tau / 360, 0.15, 12.0))
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == [
        "20 readings +inf: nothing in range",
        "3 readings -inf: closer than range_min",
        "12 readings NaN or out of range: not drawn",
        "325 distances",
    ]
    assert len(points(axes)) == 325


def test_features_are_the_graders_and_a_blind_sector_is_called_blind() -> None:
    scan, _ = as_scan("ml_drive_store")
    said = show_features(scan).texts[-1].get_text()
    for value in scan_features(scan):
        assert f"{value:.2f} m" in said
    axes = show_features(np.where(np.arange(360) < 121, math.nan, 1.0))
    assert "right minimum  blind" in axes.texts[-1].get_text()


def test_a_mirrored_scan_is_seen() -> None:
    ranges = np.full(360, 4.0)
    ranges[270 - 5 : 270 + 6] = 1.0  # at 90°, left
    axes = show_left_right(ranges)
    mirrored = next(line for line in axes.lines if line.get_label().startswith("mirrored"))
    x, y = mirrored.get_data()
    assert y[np.argmin(np.abs(x + 90))] == 1.0
    assert y[np.argmin(np.abs(x - 90))] == 4.0
    first, last = axes.get_xlim()
    assert first > last


FIELDS = {"angle_min": -math.pi, "angle_increment": math.tau / 360}


@pytest.mark.parametrize(
    "value",
    [
        RANGES,
        tuple(RANGES),
        (RANGES, *FIELDS.values()),
        (RANGES, *FIELDS.values(), 0.15, 12.0),
        SimpleNamespace(ranges=RANGES, **FIELDS),
    ],
)
def test_anything_that_is_a_scan_will_do(value: Any) -> None:
    scan, _ = as_scan(value)
    assert len(scan.ranges) == 360
    assert scan.angles[180] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("value", [None, [1.0, 2.0], "nope", {"ranges": 1}])
def test_what_is_no_scan_is_refused(value: Any) -> None:
    with pytest.raises(InputError):
        show_scan(value)


def test_another_lidar_and_a_later_scan() -> None:
    first, _ = as_scan("avoid_cart")
    later, title = as_scan("avoid_cart", at=3.0)
    assert as_scan("avoid_cart", lidar="lds01")[0].angle_min == 0.0
    assert title.endswith("3.01 s")
    assert not np.array_equal(first.ranges, later.ranges)
    with pytest.raises(InputError, match="no scan at 900 s"):
        as_scan("demo_wall", at=900.0)


def test_a_mistake_is_a_sentence_in_the_notebook(kernel: Kernel) -> None:
    said = kernel.run("show_scan('demo_wal')")
    assert said.traceback == "no scenario is called 'demo_wal'; did you mean 'demo_wall'?"
    assert said.stderr == ""


def test_without_matplotlib_the_fix_is_named(tmp_path: Path) -> None:
    (tmp_path / "matplotlib.py").write_text("raise ImportError('no such thing')\n")
    code = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n"
        "from grader.notebook import show_scan\n"
        "try:\n    show_scan('demo_wall')\nexcept Exception as error:\n    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "run `pip install matplotlib`, or prepare() in a notebook" in done.stdout


def test_a_plot_follows_the_theme_of_the_notebook(kernel: Kernel) -> None:
    said = kernel.run("import matplotlib; matplotlib.use('inline')\nshow_scan('demo_wall');")
    (shown,) = said.displays
    assert (said.traceback, said.stderr) == ("", "")
    assert shown.keys() == {"image/png", "text/html", "text/plain"}
    assert 'alt="Plot: A wall ahead, 0.01 s"' in shown["text/html"]
    assert "filter: invert" in shown["text/html"]
    own = "import matplotlib.pyplot as plt\nplt.plot([1, 2]);"
    (theirs,) = (d for d in kernel.run(own).displays if "image/png" in d)
    assert "text/html" not in theirs  # a student's own figure is left alone
