"""Exercises in a notebook: write a node in a cell, drive it, have it judged. See `help(check)`.

`%load_ext grader.notebook` and `from grader.notebook import *` both register `%%node` and import
the names below. The kernel itself never imports rclpy: nodes run in other processes.

========================  =====================================================================
`%%node FILE.py`          cell magic: the cell becomes the file FILE.py in the notebook's folder
`drive("demo_wall")`      run the file of the last `%%node` cell in one scenario, and watch it
`check("1")`              have an exercise judged, as `course grade` does
`search("1")`             look for the smallest world in which the node fails
`dataset()`               make data to learn from, as `course dataset` does
`train()`                 run the training script of exercise 2 on such data
`show_scan("demo_wall")`  plot a scan
`show_features(scan)`     plot a scan with the five features that the course's models take
`show_left_right(scan)`   plot a scan, and how it looks to a node that confuses left and right
`prepare()`               install what is missing, without restarting the kernel
========================  =====================================================================
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grader.notebook.kind import kind_errors

if TYPE_CHECKING:
    from IPython.core.interactiveshell import InteractiveShell

    from grader.notebook.datasets import NotebookDataset
    from grader.notebook.report import CheckReport

__all__ = [
    "check",
    "dataset",
    "drive",
    "prepare",
    "search",
    "show_features",
    "show_left_right",
    "show_scan",
    "train",
]

Pairs = Sequence[tuple[float, float]]


def prepare() -> None:
    """Make this kernel ready for the course: install what is missing, without a restart.

    If everything is installed it only says so, in one line. On the system Python of Debian, Ubuntu
    or Colab it runs pip in another process, and finds packages that pip put where Python does not
    look. rclpy itself stays out of the kernel: `drive` and `check` run nodes in other processes.
    """
    from grader.notebook.preparation import prepare_kernel  # noqa: PLC0415

    prepare_kernel()


def drive(
    scenario: str,
    file: str | Path | None = None,
    lidar: str | None = None,
    *,
    goals: Pairs = (),
    params: Mapping[str, str | bool | int | float] | None = None,
    duration: float | None = None,
    seed: int | None = None,
    at: float | Sequence[float] = (),
    callback: str = "",
) -> None:
    """Run a node in one scenario, print what it did, and show the replay. Nothing is judged.

    Parameters
    ----------
    scenario
        A scenario's name, such as "demo_wall" or "avoid_cart", or your own TOML file.
    file
        The node; by default the file of the last `%%node` cell. An exercise's other files are
        looked for beside it.
    lidar
        Another lidar: "default", "lds01", "lds02" or "wide".
    goals
        Goals (x, y) to send instead of the scenario's own [m].
    params
        ROS parameters by name.
    duration
        Another duration, in simulated time [s].
    seed
        Varies world and noise.
    at
        A moment [s], or two: show what the node did last by then, as `course drive --at` does.
    callback
        Of which function to show that; by default of the one that began last.
    """
    from grader.notebook.judging import drive_file  # noqa: PLC0415

    drive_file(
        scenario, file, lidar, goals=goals, params=params or {}, duration=duration, seed=seed,
        at=at, callback=callback,
    )  # fmt: skip


def check(
    name: str | int | None = None, file: str | Path | None = None, field: bool = False
) -> CheckReport | None:
    """Have an exercise judged by all its checks, as `course grade` does.

    Shows the table of checks, what went wrong, and the replay at that moment. The result is for you
    alone; whoever marks your work runs the same checks on another machine.

    Parameters
    ----------
    name
        The exercise by name or number ("1"), or only some of its checks
        ("1:clear_zone,slow_zone"; those that they need are run too). By default the exercise of the
        last `%%node` cell.
    file
        The node's file; by default the exercise's, in the notebook's folder.
    field
        Run the field checks too: other sensors and networks; a badge, no points.

    Returns
    -------
    CheckReport or None
        `.score`, `.max_score` [points] and `.checks`; None if nothing could be judged (a message
        says why).
    """
    from grader.notebook.judging import check_file  # noqa: PLC0415
    from grader.notebook.validation import validated  # noqa: PLC0415

    return validated(check_file(None if name is None else str(name), file, field=field))


def search(
    name: str | int | None = None,
    file: str | Path | None = None,
    *,
    minutes: float | None = None,
    tries: int | None = None,
    seed: int = 0,
    field: bool = False,
) -> None:
    """Look for the smallest world in which a node fails, as `course search` does; show its replay.

    It fails that touches something, dies, breaks a limit, or stands for ever though its way is
    free. Nothing is judged.

    Parameters
    ----------
    name
        The exercise by name or number; by default that of the last `%%node` cell.
    file
        The node's file; by default the exercise's, in the notebook's folder.
    minutes, tries
        When to give up: after a minute by default, or after so many worlds.
    seed
        Where to begin. With a number of tries, the same seed finds the same world.
    field
        Other sensors and networks too, as for the badge.
    """
    from grader.notebook.judging import search_file  # noqa: PLC0415

    wanted = None if name is None else str(name)
    search_file(wanted, file, minutes=minutes, tries=tries, seed=seed, field=field)


def dataset(file: str | Path = "train.npz", *, scans: int = 2000, seed: int = 1) -> NotebookDataset:
    """Write a file with labelled scans for training, as `course dataset` does.

    Parameters
    ----------
    file
        The .npz file to write.
    scans
        Number of scans.
    seed
        Another seed gives other rooms and other scans.

    Returns
    -------
    NotebookDataset
        `.ranges` (scans, 360) [m], `.speed` (scans,) [m/s]: what an expert would drive,
        `.room` (scans,), and `.angles` (360,) [rad], positive to the left.
    """
    with kind_errors():
        from grader.notebook.datasets import write_dataset  # noqa: PLC0415

        return write_dataset(Path(file), scans=scans, seed=seed)


def train(
    file: str | Path | None = None,
    *,
    data: str | Path = "train.npz",
    out: str | Path = "velocity_model.pkl",
    onnx: str | Path = "velocity_model.onnx",
) -> bool:
    """Run a training script; show what it prints, how long it takes and which files it writes.

    Runs `python FILE --data DATA --out OUT --onnx ONNX`; if DATA does not exist it is made first.
    The models stay in the notebook's folder, and `drive` gives them to the node.

    Parameters
    ----------
    file
        The script; by default train_velocity_model.py.
    data, out, onnx
        The file with the data, and the two files that the script writes.

    Returns
    -------
    bool
        Whether the script succeeded and wrote both files.
    """
    from grader.notebook.datasets import train_model  # noqa: PLC0415

    return train_model(
        Path(file or "train_velocity_model.py"), data=Path(data), out=Path(out), onnx=Path(onnx)
    )


def show_scan(scan: Any, *, lidar: str | None = None, at: float = 0.0, ax: Any = None) -> Any:
    """Plot a scan seen from above: the robot in the middle, ahead is up, left is left.

    Parameters
    ----------
    scan
        A scenario's name; or a LaserScan, or anything else with its fields; or a tuple (ranges,
        angle_min, angle_increment[, range_min, range_max]) in metres and radians; or only the
        ranges, as the default lidar orders them.
    lidar
        For a scenario: another lidar ("lds01", "lds02", "wide").
    at
        For a scenario: the time of the scan [s]; the robot stands still.
    ax
        The matplotlib Axes to draw on; by default a new figure.

    Returns
    -------
    matplotlib.axes.Axes
    """
    with kind_errors():
        from grader.notebook.plots import plot_scan  # noqa: PLC0415

        return plot_scan(scan, lidar, at, ax)


def show_features(scan: Any, *, lidar: str | None = None, at: float = 0.0, ax: Any = None) -> Any:
    """Plot a scan with its three sectors and the five features that the course's models take.

    Parameters and return value are those of `show_scan`.
    """
    with kind_errors():
        from grader.notebook.plots import plot_features  # noqa: PLC0415

        return plot_features(scan, lidar, at, ax)


def show_left_right(scan: Any, *, lidar: str | None = None, at: float = 0.0, ax: Any = None) -> Any:
    """Plot a scan's readings over their angle, with left and right marked, and mirrored as well.

    The mirrored line is the scan as a node sees it that counts beams clockwise. Parameters and
    return value are those of `show_scan`.
    """
    with kind_errors():
        from grader.notebook.plots import plot_left_right  # noqa: PLC0415

        return plot_left_right(scan, lidar, at, ax)


def load_ipython_extension(shell: InteractiveShell) -> None:
    """Register `%%node` and import the public names: IPython calls this for `%load_ext`."""
    from grader.notebook.magic import register  # noqa: PLC0415

    register(shell)
    shell.user_ns.update({name: globals()[name] for name in __all__})


def _register_where_a_kernel_runs() -> None:
    """Register `%%node` if a kernel imports this, as `from grader.notebook import *` does."""
    from grader.notebook.show import shell  # noqa: PLC0415

    if (running := shell()) is not None:
        from grader.notebook.magic import register  # noqa: PLC0415

        register(running)


_register_where_a_kernel_runs()
