"""Which attacks succeed without which layer of isolation, as a table.

Each layer is switched off in turn while the others stay on, for a grader that runs as root and for
one that runs as an ordinary user. `make attacks` prints the table; `--write` puts it into
docs/attacks.md.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT), str(Path(__file__).resolve().parent)]

from arena import HOSTILE, Arena, claim  # noqa: E402

from grader.host.sandbox import layers as isolation  # noqa: E402
from grader.host.sandbox import users as privileges  # noqa: E402
from grader.host.sandbox.layers import LAYERS, LIMITS  # noqa: E402
from grader.link.hosts import LAYER_TEXTS, ForkServer  # noqa: E402
from sim.messages import EPOCH_NS  # noqa: E402

DOCUMENT = ROOT / "docs" / "attacks.md"
NOBODY = 65534
FAMILIES = ("read_", "escape_", "exhaust_")  # the others don't depend on layers
ALL_OFF = "all but the limits"
KNOWN = {"leaves files behind", "takes more than 64 MiB of shared memory"}  # /dev/shm is shared
BEGIN, END = "<!-- table: begin -->", "<!-- table: end -->"

Openings = dict[str, list[str]]  # what is possible: which attacks showed it


def main(arguments: Sequence[str] | None = None) -> int:
    """Try, print, and write down if asked to; 1 if anything is open with all layers on."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="put the table into docs/attacks.md")
    parser.add_argument("--ordinary", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.ordinary:
        _become_ordinary()
        print(json.dumps(survey(rows())))
        return 0
    tables: dict[str, dict[str, Openings]] = {}
    if os.getuid() == 0:
        tables["root"] = survey([row for row in rows() if row != ALL_OFF])
        tables["an ordinary user"] = _as_ordinary()
    else:
        tables["an ordinary user"] = survey(rows())
    text = markdown(tables)
    print(text)
    if options.write:
        before, rest = DOCUMENT.read_text("utf-8").split(BEGIN)
        DOCUMENT.write_text(f"{before}{BEGIN}\n{text}{END}{rest.split(END)[1]}", "utf-8")
    private = {who: "mounts" in table for who, table in tables.items()}
    return int(any(set(t[""]) - (set() if private[who] else KNOWN) for who, t in tables.items()))


def rows() -> list[str]:
    """Return what is switched off, one after the other; "" for nothing."""
    return ["", *(layer for layer in LAYERS if layer != LIMITS), ALL_OFF]


def survey(off: Sequence[str]) -> dict[str, Openings]:
    """Try the attacks; return what each row opens."""
    found: dict[str, Openings] = {}
    with ForkServer(EPOCH_NS) as forkserver:
        here = forkserver.layers
    for row in off:
        if row in ("", ALL_OFF) or row in here:
            layers = [LIMITS] if row == ALL_OFF else [layer for layer in LAYERS if layer != row]
            found[row] = openings(layers)
            print(f"without {row or 'nothing'}: {len(found[row])}", file=sys.stderr)
    return found


def openings(layers: Sequence[str]) -> Openings:
    """Return what is possible behind these layers, and which attacks show it."""
    found: Openings = {}
    with ForkServer(EPOCH_NS, layers=layers) as forkserver, Arena(forkserver.layers) as arena:
        for path in HOSTILE:
            if not path.stem.startswith(FAMILIES) or claim(path).hangs or claim(path).full:
                continue
            if path.stem == "exhaust_deep_folders":  # shows nothing here
                continue
            grading = arena.grade(path, forkserver, hasty=True, everything=False)
            for what in (*arena.said(grading.recordings), *arena.losses()):
                found.setdefault(what.partition(":")[0], []).append(path.stem)
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


def _as_ordinary() -> dict[str, Openings]:
    done = subprocess.run(
        [sys.executable, "-B", __file__, "--ordinary"],
        stdout=subprocess.PIPE, text=True, check=True, cwd="/", timeout=1_800,
        env={"PATH": "/usr/bin:/bin", "TMPDIR": "/tmp", "HOME": "/tmp"},
    )  # fmt: skip
    table: dict[str, Openings] = json.loads(done.stdout.splitlines()[-1])
    return table


def _become_ordinary() -> None:
    if os.getuid() != 0:
        return
    paths = [*isolation.needed_paths(), ROOT]
    if not (privileges.own_mounts() and privileges.open_to_others(paths)):
        raise SystemExit("the interpreter is out of reach for another user")
    os.setgroups([])
    os.setresgid(NOBODY, NOBODY, NOBODY)
    os.setresuid(NOBODY, NOBODY, NOBODY)


if __name__ == "__main__":
    sys.exit(main())
