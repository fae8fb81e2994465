"""Every program in the lesson runs, and prints what the page says that it prints."""

import contextlib
import json
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from lesson_pages import PAGES, ROOT, Block, blocks

import grader.drive
from grader.cli import cli
from grader.course.installed import OPTIONAL, why_not
from grader.launchers import ForkServerPool
from grader.recording import Recording

ELISION = "…"
STARTED = re.compile(r'executable="(\w+)"')  # by a launch file
RUNNER = """
import contextlib, io, json, os, sys
namespace, said = {"__name__": "page"}, []
for folder, block in json.load(sys.stdin):
    if not os.path.samefile(folder, "."):  # another page
        os.chdir(folder)
        namespace = {"__name__": "page"}
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(block, "page", "exec"), namespace)
    said.append(out.getvalue())
print(json.dumps(said))
"""


def is_node(block: Block) -> bool:
    return block.info == "python" and "caption" in block.options


def snippets(page: Path) -> list[Block]:
    return [block for block in blocks(page) if block.info == "python" and not is_node(block)]


def nodes() -> list[Block]:
    return [block for page in PAGES for block in blocks(page) if is_node(block)]


def write_nodes(folder: Path) -> None:
    for block in nodes():
        (folder / block.options["caption"]).write_text(block.text, "utf-8")


def is_maker(block: Block) -> bool:
    """Return whether a command runs a listing that writes what another listing reads."""
    return block.info == "console" and block.text.startswith("$ python3 ")


def make(makers: list[Block], folder: Path) -> None:
    """Run makers in a folder with all nodes; what they print is in `said.json`."""
    write_nodes(folder)
    commands = [[sys.executable, *shlex.split(block.text)[2:]] for block in makers]
    options: Any = {"capture_output": True, "text": True, "cwd": folder, "timeout": 60}
    said = [subprocess.run(command, check=True, **options).stdout for command in commands]
    (folder / "said.json").write_text(json.dumps(said))


def commands() -> list[tuple[Block, Block | None]]:
    """Return each command of the pages, and the block that shows what it prints, if any."""
    found = []
    for page in PAGES:
        listed = [*blocks(page), None]
        for block, after in pairwise(listed):
            if block is not None and block.info == "console":
                shows = after is not None and after.info.startswith("output")
                found.append((block, after if shows else None))
    return found


def same(expected: str, actual: str) -> None:
    """Compare line by line; a line of `…` stands for any lines."""
    form = "".join(
        r"(?:.*\n)*" if line.rstrip() == ELISION else f"{re.escape(line.rstrip())}\n"
        for line in expected.rstrip().splitlines()
    )
    printed = "".join(f"{line.rstrip()}\n" for line in actual.rstrip().splitlines())
    assert re.fullmatch(form, printed), f"not printed:\n{expected}\nbut:\n{printed}"


DEEP = ("torch", "keras")


@pytest.mark.parametrize("deep", [False, pytest.param(True, marks=pytest.mark.deep)])
def test_snippets_print_what_the_page_says(deep: bool, tmp_path: Path) -> None:
    """One process runs them all, each page's in a folder and with names of their own."""
    listed, needs = [], set()
    for page in filter(snippets, PAGES):
        found = set(
            re.findall(r"(?m)^(?:import|from) (\w+)", "".join(b.text for b in snippets(page)))
        )
        if deep is not found.isdisjoint(DEEP):
            needs |= found & OPTIONAL.keys()
            listed += [(tmp_path / page.stem, block) for block in snippets(page)]
    if lacks := why_not(sorted(needs)):
        pytest.skip(lacks)
    for folder, page in {folder: block.page for folder, block in listed}.items():
        folder.mkdir()
        write_nodes(folder)
        for block in blocks(ROOT / "lessons" / f"{page}.md"):
            if block.info == "console" and "--bag" in block.text:  # the snippets read it
                words = shlex.split(block.text)[2:]
                course = [sys.executable, "-m", "grader.cli", *words]
                subprocess.run(course, check=True, capture_output=True, timeout=60, cwd=folder)
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", RUNNER],
        input=json.dumps([(str(folder), block.text) for folder, block in listed]),
        capture_output=True, text=True, check=False, timeout=60, cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    for (_, block), said in zip(listed, json.loads(done.stdout), strict=True):
        everything = blocks(ROOT / "lessons" / f"{block.page}.md")
        after = everything[everything.index(block) + 1 :]
        assert after, f"{block.place} prints something that the page does not show"
        assert after[0].info == "output", f"{block.place}: no output below it"
        same(after[0].text, said)


@pytest.mark.parametrize(("command", "shown"), commands(), ids=lambda b: b and b.place)
def test_commands_print_what_the_page_says(
    command: Block,
    shown: Block | None,
    forkservers: ForkServerPool,
    made_once: Callable[..., Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    recordings: list[Recording] = []
    drive_node = grader.drive.drive_node

    def drive(*args: object, **options: object) -> Recording:
        recordings.append(drive_node(*args, **options))  # type: ignore[arg-type]
        return recordings[-1]

    monkeypatch.setattr(grader.drive, "drive_node", drive)
    warm = lambda libraries=(), **_: contextlib.nullcontext(forkservers.of(libraries))  # noqa: E731
    monkeypatch.setattr("grader.cli.drive.start_forkserver", warm)
    monkeypatch.setenv("COLUMNS", "80")
    write_nodes(tmp_path)
    if "exercises/" in command.text:
        shutil.copytree(ROOT / "exercises", tmp_path / "exercises")
    monkeypatch.chdir(tmp_path)
    if makers := list(filter(is_maker, blocks(ROOT / "lessons" / f"{command.page}.md"))):
        if lacks := why_not(["sklearn"]):  # importing it here would cost a second
            pytest.skip(lacks)
        made = made_once(f"made-on-{command.page}", partial(make, makers))
        if command in makers:
            assert shown is not None
            same(shown.text, json.loads((made / "said.json").read_text())[makers.index(command)])
            return
        shutil.copytree(made, tmp_path, dirs_exist_ok=True)

    prompt, course, *words = shlex.split(command.text.replace("\\\n", " "))
    assert (prompt, course) == ("$", "course"), command.place
    done = CliRunner().invoke(cli, words, standalone_mode=False)
    assert done.exception is None, done.output
    if shown is None:
        assert done.return_value == 0
        return
    log = "\n".join(line.text for line in recordings[0].log if line.level == "info")
    printed, measured, after = done.output.partition("\n  Compute: ")  # each machine has its own
    assert measured
    looked = after[after.find("\nWhat ran") :] if "--at" in words else ""
    same(shown.text, log if shown.info == "output log" else f"{printed}\n{looked}")


def test_every_program_is_run() -> None:
    driven = {shlex.split(c.text)[2 if is_maker(c) else 3] for c, _ in commands()}
    written = {block.options["caption"] for block in nodes()}
    launching = [block.text for block in nodes() if block.options["caption"] in driven]
    launched = {f"{name}.py" for text in launching for name in STARTED.findall(text)}
    assert written <= driven | launched
    for block in nodes():
        compile(block.text, block.options["caption"], "exec")
    count = len(written), sum(len(snippets(page)) for page in PAGES)
    assert count[0] >= 7 and count[1] >= 10, f"only {count[0]} nodes and {count[1]} snippets"


def test_comparison_notices_differences() -> None:
    same("a\n…\nc\n", "a\nb\nc\n")
    for expected, actual in (
        ("a\n", "b\n"),
        ("a\n…\nc\n", "a\nb\n"),
        ("…\nb\n", "b\nc\n"),
        ("b\n…\n", "a\nb\n"),
        ("…\na\nb\n…\n", "a\nx\nb\n"),
    ):
        with pytest.raises(AssertionError):
            same(expected, actual)
