"""Which attacks succeed without which layer of isolation, as a table.

Each layer is switched off in turn while the others stay on, for a grader that runs as root and for
one that runs as an ordinary user; then the machine itself offers less: an older Landlock, a full
disk, no user namespaces. `make attacks` prints the table; `--write` puts it into docs/attacks.md.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT), str(Path(__file__).resolve().parent), str(ROOT / "tests" / "grader")]

from arena import HOSTILE, Arena  # noqa: E402

from grader.launchers import fork_server  # noqa: E402
from rclpy_virtual_time.host.sandbox import users as privileges  # noqa: E402
from rclpy_virtual_time.host.sandbox.kernel_filters import NEWEST  # noqa: E402
from rclpy_virtual_time.host.sandbox.layers import FILES, LAYERS, LIMITS  # noqa: E402
from rclpy_virtual_time.link.hosts import LAYER_TEXTS  # noqa: E402
from rclpy_virtual_time.tests import ordinary  # noqa: E402

DOCUMENT = ROOT / "docs" / "attacks.md"
FAMILIES = ("read", "escape", "exhaust")  # the others don't depend on layers
ALL_OFF = "all but the limits"
OLD_LANDLOCK = {f"nothing, but Landlock is of version {abi}": abi for abi in (1, 2, 3)}
FULL_DISK = "nothing, but the disk with the temporary folders is full"
NO_NAMESPACES = "nothing, but nobody may make user namespaces"
DISK, LEFT = 16 << 20, 1 << 20  # [bytes] of the full disk, and what is left of it
KNOWN = {"leaves files behind", "takes more than 64 MiB of shared memory"}  # /dev/shm is shared
BEGIN, END = "<!-- table: begin -->", "<!-- table: end -->"

Openings = dict[str, list[str]]  # what is possible: which attacks showed it


def main(arguments: Sequence[str] | None = None) -> int:
    """Try, print, and write down if asked to; 1 if anything is open with all layers on."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="put the table into docs/attacks.md")
    parser.add_argument("--row", action="append", help="only rows that begin like this")
    parser.add_argument("--inside", nargs=3, help=argparse.SUPPRESS)  # who, row, disk
    options = parser.parse_args(arguments)
    if options.inside:
        print(json.dumps(_survey_inside(*options.inside)))
        return 0
    whose = ["root", "an ordinary user"] if os.getuid() == 0 else ["an ordinary user"]
    tables: dict[str, dict[str, Openings]] = {who: {} for who in whose}
    for who, table in tables.items():
        for row in rows(who):
            if options.row and not any(
                (row or "nothing").startswith(wanted) for wanted in options.row
            ):
                continue
            found = _survey(who, row)
            if found is not None:
                table[row] = found
                print(f"{who}, without {row or 'nothing'}: {len(found)}", file=sys.stderr)
    text = markdown(tables)
    print(text)
    if options.write:
        before, rest = DOCUMENT.read_text("utf-8").split(BEGIN)
        DOCUMENT.write_text(f"{before}{BEGIN}\n{text}{END}{rest.split(END)[1]}", "utf-8")
    private = {who: "mounts" in table for who, table in tables.items()}
    return int(
        any(set(t.get("", ())) - (set() if private[who] else KNOWN) for who, t in tables.items())
    )


def rows(who: str) -> list[str]:
    """Return what is switched off or missing, one after the other; "" for nothing."""
    off = ["", *(layer for layer in LAYERS if layer != LIMITS), *OLD_LANDLOCK, FULL_DISK]
    return off if who == "root" else [*off, NO_NAMESPACES, ALL_OFF]


def _survey(who: str, row: str) -> Openings | None:
    """Try the attacks in a process that is set up for the row; None if it can't be."""
    with tempfile.TemporaryDirectory() as disk:
        Path(disk).chmod(0o755)
        done = subprocess.run(
            [sys.executable, "-B", __file__, "--inside", who, row, disk],
            stdout=subprocess.PIPE, text=True, check=True, cwd="/", timeout=1_800,
            env={"PATH": "/usr/bin:/bin", "TMPDIR": "/tmp", "HOME": "/tmp"},
        )  # fmt: skip
    found: Openings | None = json.loads(done.stdout.splitlines()[-1])
    return found


def _survey_inside(who: str, row: str, disk: str) -> Openings | None:
    if row == FULL_DISK and not _fill(Path(disk)):
        return None
    if who != "root":
        ordinary.become_ordinary()
    if row == NO_NAMESPACES:
        ordinary.refuse_namespaces()
    return _openings_of(row)


def _fill(place: Path) -> bool:
    """Mount a disk for temporary folders that is nearly full; tell whether that can be done."""
    if not privileges.own_mounts():
        return False
    try:
        privileges.mount("tmpfs", str(place), "tmpfs", 0, f"mode=1777,size={DISK}")
    except OSError:
        return False
    (place / "full").write_bytes(bytes(DISK - LEFT))
    place.chmod(0o1777)
    tempfile.tempdir = str(place)
    return True


def _openings_of(row: str) -> Openings | None:
    landlock = OLD_LANDLOCK.get(row, NEWEST)
    with fork_server(landlock=landlock) as forkserver:
        here = forkserver.layers
    if (row in LAYERS and row not in here) or (row in OLD_LANDLOCK and FILES not in here):
        return None
    layers = [LIMITS] if row == ALL_OFF else [layer for layer in LAYERS if layer != row]
    return openings(layers, landlock)


def openings(layers: Sequence[str], landlock: int = NEWEST) -> Openings:
    """Return what is possible behind these layers, and which attacks show it."""
    found: Openings = {}
    with (
        fork_server(layers=layers, landlock=landlock) as forkserver,
        Arena(forkserver.layers) as arena,
    ):
        for trick in HOSTILE:
            if trick.path.stem not in FAMILIES or trick.hangs or trick.full:
                continue
            if trick.function == "deep_folders":  # shows nothing here
                continue
            path = arena.tricked(trick)
            grading = arena.grade(path, forkserver, hasty=True, everything=False)
            for what in (*arena.said(grading.recordings), *arena.losses()):
                found.setdefault(what.partition(":")[0], []).append(trick.name)
    return found


def markdown(tables: dict[str, dict[str, Openings]]) -> str:
    """Return the tables for people."""
    lines = []
    for who, table in tables.items():
        lines += [
            "",
            f"### The grader runs as {who}",
            "",
            "| Switched off | What opens |",
            "|---|---|",
        ]
        for row, found in table.items():
            name = f"`{row}`: {LAYER_TEXTS[row]}" if row in LAYER_TEXTS else row or "nothing"
            lines.append(f"| {name} | {'; '.join(sorted(found)) or '—'} |")
    return "\n".join(lines).lstrip("\n") + "\n"


if __name__ == "__main__":
    sys.exit(main())
