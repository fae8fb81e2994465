"""Make the replays of the lesson's pages: what `{watch}` shows, driven as `course drive` does.

`python -m grader.authoring.lesson_replays OUT` drives the listings of lessons/*.md that have
`:drive:` below a `{watch} NAME`, and writes OUT/NAME.html.
"""

import argparse
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

from grader.authoring.pitfalls import LIBRARIES
from grader.course.exercises import ROOT
from grader.course.submission import find_submission
from grader.drive import arguments_of, drive_node, scenario_for
from grader.errors import InputError
from grader.launchers import fork_server
from grader.report.page import page_html, page_payload
from rclpy_virtual_time import ForkServer

COMMAND = argparse.ArgumentParser("course drive")  # the options that a page has use for
COMMAND.add_argument("file")
COMMAND.add_argument("--scenario", required=True)
COMMAND.add_argument("--lidar")
COMMAND.add_argument("--duration", type=float)
COMMAND.add_argument("--seed", type=int)
COMMAND.add_argument("--param", action="append", default=[])

LESSONS = ROOT / "lessons"
MADE = re.compile(r"(?m)^\$ python3 (\S+)$")  # a listing that writes what another reads
WATCHED = re.compile(r"(?m)^```\{watch\} (?P<name>\w+)\n:drive: (?P<drive>.+)$")
LISTING = re.compile(
    r"(?ms)^```\{code-block\} python\n:caption: (?P<file>\S+)\n\n(?P<text>.*?)^```$"
)


def watched() -> dict[str, str]:
    """Return what each replay drives: the arguments of `course drive`, by the replay's name."""
    pages = [page.read_text("utf-8") for page in sorted(LESSONS.glob("*.md"))]
    return {found["name"]: found["drive"] for page in pages for found in WATCHED.finditer(page)}


def write(out: Path, forkserver: ForkServer) -> None:
    """Drive every listing that is watched, and write its replay.

    Raises InputError: no page has such a listing.
    """
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        for page in LESSONS.glob("*.md"):
            for found in LISTING.finditer(page.read_text("utf-8")):
                Path(name, found["file"]).write_text(found["text"], "utf-8")
            for maker in MADE.findall(page.read_text("utf-8")):
                subprocess.run([sys.executable, maker], check=True, cwd=name, capture_output=True)
        for replay, words in watched().items():
            (out / f"{replay}.html").write_text(driven(Path(name), words, forkserver), "utf-8")


def driven(folder: Path, words: str, forkserver: ForkServer) -> str:
    """Return the replay of `course drive WORDS` in a folder, without what it computed on."""
    given = COMMAND.parse_args(shlex.split(words))
    file = folder / given.file
    if not file.is_file():
        raise InputError(f":drive: {words}: expected a listing with the caption {given.file}")
    recording = drive_node(
        find_submission(file),
        scenario_for(given.scenario, lidar=given.lidar, duration=given.duration),
        forkserver,
        seed=given.seed,
        arguments=arguments_of(given.param),
    )
    payload = page_payload(None, [recording], f"Drive of {file.name}")
    (shown,) = payload["replays"]
    shown["compute"] = []
    for line in shown["log"]:
        line["text"] = LIBRARIES.sub("", line["text"])
    return page_html(payload)


def main(arguments: list[str]) -> int:
    """Write the replays into the folder that is given."""
    if len(arguments) != 1 or arguments[0].startswith("-"):
        raise InputError("expected a folder for the replays")
    with fork_server() as forkserver:
        write(Path(arguments[0]), forkserver)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
