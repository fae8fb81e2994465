"""Count the tracked lines of each kind in budget.toml; `make lint` refuses too many."""

import subprocess
import sys
import tomllib
from pathlib import Path

CI = Path(__file__).resolve().parent
LISTED = ["git", "-C", str(CI.parent), "ls-files", "-z", "--"]


def lines(patterns: list[str]) -> int:
    """Return how many lines the files of these git patterns have; binary files have none."""
    names = subprocess.run([*LISTED, *patterns], check=True, capture_output=True).stdout
    paths = (CI.parent / name.decode() for name in names.split(b"\0") if name)
    texts = (path.read_bytes() for path in paths if path.is_file())
    return sum(text.count(b"\n") for text in texts if b"\0" not in text)


def main() -> int:
    """Print a line for each kind; 1 if one is over its budget, 0 also where there is no git."""
    over = 0
    for kind, row in tomllib.loads((CI / "budget.toml").read_text("utf-8")).items():
        try:
            have = lines(row["files"])
        except (OSError, subprocess.CalledProcessError):
            return 0
        most = row["most"]
        over |= have > most
        said = f": {have - most:,} too many (.ci/budget.toml)" if have > most else ""
        print(f"  lines of {kind:10} {have:7,} of {most:,}{said}")
    return int(over)


if __name__ == "__main__":
    sys.exit(main())
