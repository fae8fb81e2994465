"""`course dataset`: make training data."""

from __future__ import annotations

from pathlib import Path

import click

from grader.cli.results import FULL, check_writable
from grader.errors import InputError
from grader.report.echo import echo

EXAMPLES = """\b
Examples:
  course dataset train.npz
  course dataset other_rooms.npz --seed 7 --scans 1000
"""


@click.command(epilog=EXAMPLES)
@click.argument("out", type=click.Path(path_type=Path))
@click.option("--seed", type=click.IntRange(0, 10**6), default=1, help="Other rooms, other scans.")
@click.option("--scans", type=click.IntRange(100, 100_000), default=2000, help="How many.")
def dataset(out: Path, seed: int, scans: int) -> int:
    """Make data to learn from: OUT.npz with scans of the mock lidar and an expert's speeds."""
    from grader.models.dataset import baselines, make_dataset  # noqa: PLC0415

    if out.suffix != ".npz":
        raise InputError(f"{out}: expected a name that ends in .npz")
    check_writable(out)
    made = make_dataset(scans, seed)
    made.save(out)
    echo(f"{out}: {baselines(made)}")
    return FULL
