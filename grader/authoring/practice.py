"""Write what the published expert says about the scans that students learn from.

`python -m grader.authoring.practice` makes `grader/models/practice.npz` anew. A student's copy has
it in the expert's place; the scans themselves it makes again from their seeds.
"""

import numpy as np

from grader.models.dataset import PRACTICE, make_dataset
from grader.models.scans import make_scans

# Seeds of `course dataset` and of the probes' models; then those of ml_training, seed 41
ROWS = {**dict.fromkeys(range(1, 10), 2000), 82: 2000, 83: 600}


def practice(seed: int, rows: int) -> dict[str, np.ndarray[tuple[int], np.dtype[np.floating]]]:
    """Return the arrays of a seed: labels, and by what its scans are known again."""
    exact = make_scans(rows, seed, blind=True, plain=False).exact
    return {
        f"speed{seed}": make_dataset(rows, seed).speed.astype(np.float32),
        f"nearest{seed}": exact.min(axis=1).astype(np.float16),
    }


def main() -> None:
    """Write the file."""
    made = {name: a for seed, rows in ROWS.items() for name, a in practice(seed, rows).items()}
    np.savez_compressed(PRACTICE, allow_pickle=False, **made)
    print(f"{PRACTICE}: {PRACTICE.stat().st_size:,} bytes")


if __name__ == "__main__":
    main()
