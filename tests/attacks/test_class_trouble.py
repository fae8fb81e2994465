"""A batch that is disturbed: workers killed, Ctrl-C, a full disk; the next run goes on."""

import contextlib
import csv
import os
import shutil
import signal
import subprocess
from pathlib import Path

import pytest
from arena import EXERCISE, FULL, HOSTILE, ROOT, children
from test_class import FILE, HONEST, LIMIT, assert_complete, stored, verdicts
from whole_class import COURSE, hand_in, hand_in_hostile

OPTIONS = ("--exercise", EXERCISE.slug, "--canaries", "0", "--trust")
HONEST_ONES = ("ann", "bob", "eve", "kim")


def workers_of(pid: int) -> list[int]:
    """Return the worker processes of a batch."""
    found = []
    for child in children(pid):
        with contextlib.suppress(OSError):
            if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes():
                found.append(int(child))
    return found


@pytest.mark.long
@pytest.mark.skipif(not FULL, reason="workers killed, Ctrl-C, resumed: make attacks")
def test_workers_killed_ctrl_c_and_resumed(tmp_path: Path) -> None:
    """Among hostile ones, one of which kills what it can; honest ones get what they deserve."""
    for name in HONEST_ONES:
        hand_in(tmp_path / "in", name, {FILE: f"# {name}\n".encode() + HONEST})
    hostile = [trick for trick in HOSTILE if trick.name in ("escape_kill_all", "feedback_html")]
    students = hand_in_hostile(tmp_path / "in", hostile, FILE)
    undisturbed, out = tmp_path / "undisturbed", tmp_path / "out"
    begin = [*COURSE, str(tmp_path / "in"), *OPTIONS, "--out"]
    subprocess.run([*begin, str(undisturbed)], check=True, cwd=ROOT, stdout=subprocess.DEVNULL)

    command = [*begin, str(out), "--workers", "2"]
    with subprocess.Popen(
        command,
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
        preexec_fn=heed_ctrl_c,  # noqa: PLW1509  (it only sets a handler)
    ) as batch:
        assert batch.stdout is not None
        batch.stdout.readline()
        killed = workers_of(batch.pid)
        os.kill(killed[-1], signal.SIGKILL)
        said = [batch.stdout.readline() for _ in range(2)]
        batch.send_signal(signal.SIGINT)
        said += batch.stdout.readlines()
    assert batch.returncode not in (0, 1)
    assert any("will retry: its worker died" in line for line in said), said
    assert not any(Path(f"/proc/{worker}").exists() for worker in killed)
    assert_complete(out)  # what is graded by then
    marks = [*COURSE[:-1], "marks", "score", str(out), "12", "--student", "ann", "--why", "a test"]
    subprocess.run(marks, check=True, cwd=ROOT, stdout=subprocess.DEVNULL)

    done = subprocess.run(command, check=False, cwd=ROOT, capture_output=True, timeout=LIMIT)
    assert done.returncode == 0, done.stdout + done.stderr
    everybody = [*HONEST_ONES, *students]
    assert verdicts(out, everybody) == verdicts(undisturbed, everybody)
    assert len(stored(out)) == len(everybody)
    assert_complete(out)
    rows = csv.DictReader((out / "scores.csv").read_text("utf-8-sig").splitlines())
    assert {row["student"]: row["points"] for row in rows}["ann"] == "12"


def heed_ctrl_c() -> None:
    """Take Ctrl-C, which background jobs of a shell ignore."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


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
        ["mount", "-o", "remount,size=200m", str(place)],
        batch,
        ["cp", "-r", str(place / "out"), str(taken)],
        place=place,
        size="2m",
    )  # two gradings with their recordings don't fit

    first, _, second, _ = (line for line in done.stdout.splitlines() if line.startswith("exit"))
    assert (first, second) == ("exit code 2", "exit code 0"), done.stdout + done.stderr
    (said,) = done.stderr.splitlines()
    assert "the disk is full" in said
    assert "run the same command again" in said
    assert_complete(taken)
    gradings = [one.grading for one in stored(taken).values()]
    assert [grading and grading["score"] for grading in gradings] == [100, 100, 100]
