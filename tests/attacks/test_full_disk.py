"""A disk that is full, for real: the batch says so and ends, and the next run goes on."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from arena import EXERCISE, ROOT
from test_class import FILE, HONEST, assert_complete
from whole_class import COURSE, hand_in

from grader.classroom.queue.store import Store

OPTIONS = ("--exercise", EXERCISE.slug, "--canaries", "0", "--trust")


def mounted(*steps: list[str], place: Path, size: str) -> subprocess.CompletedProcess[str]:
    """Run steps with a disk of that size at `place`, which only they see."""
    script = [f"mount -t tmpfs -o size={size} none {place} || exit 9"]
    script += [" ".join(f"'{word}'" for word in step) + "; echo exit code $?" for step in steps]
    rights = [] if os.getuid() == 0 else ["--map-root-user"]
    return subprocess.run(
        ["unshare", "--mount", *rights, "sh", "-c", "\n".join(script)],
        capture_output=True, text=True, check=False, cwd=ROOT,
    )  # fmt: skip


@pytest.mark.long
def test_a_full_disk_ends_the_batch_and_the_next_run_goes_on(tmp_path: Path) -> None:
    place, taken = tmp_path / "disk", tmp_path / "taken"
    place.mkdir()
    if shutil.which("unshare") is None or mounted(["true"], place=place, size="1m").returncode:
        pytest.skip("no mounts on this machine")
    for name in ("ann", "bob", "eve"):
        hand_in(tmp_path / "in", name, {FILE: f"# {name}\n".encode() + HONEST})
    batch = [*COURSE, str(tmp_path / "in"), "--out", str(place / "out"), *OPTIONS]
    done = mounted(
        batch,
        ["sh", "-c", f"cat /dev/zero > {place}/fill"],  # to the last byte
        batch,
        [*COURSE[:-1], "report", str(place / "out")],
        ["rm", str(place / "fill")],
        ["mount", "-t", "tmpfs", "-o", "remount,size=200m", "none", str(place)],
        batch,
        ["cp", "-r", str(place / "out"), str(taken)],
        place=place,
        size="2m",
    )  # two gradings with their recordings don't fit

    codes = [line[-1] for line in done.stdout.splitlines() if line.startswith("exit")]
    assert codes == list("21220000"), done.stdout + done.stderr
    first, _, second, report = done.stderr.splitlines()
    for said in (first, second):
        assert "the disk is full" in said
        assert "run the same command again" in said
    assert "no space is left on its disk" in report
    assert_complete(taken)
    with Store(taken / "store.sqlite") as store:
        gradings = [one.grading for one in store.results() if one.attempts]
    assert [grading and grading["score"] for grading in gradings] == [100, 100, 100]
