"""The documents: what they mention is there, and what they say of the course is true."""

import importlib.util
import re
import shlex
import subprocess
from pathlib import Path, PurePosixPath

import click
from documents import ROOT, Document, documents, tracked

from grader.claims.mutants import mutants
from grader.cli import cli
from grader.cli.gone import what_replaces
from grader.course.exercises import all_exercises
from grader.exercises.obstacle_avoidance import test_core
from sim.scenario_files import load_scenario

OURS = documents(
    "README.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "SECURITY.md",
    "docs/",
    "notebooks/README.md",
    "rclpy_virtual_time/",
)
PLACEHOLDER = re.compile(r"\b(NAME|FILE|EXERCISE|FOLDER)\b|\*")
WALK = "docs/add-an-exercise.md"  # its reader makes files of her own
MADE = re.compile(r"(?m)^`([\w./-]+)`")  # in the walk


# --- links -----------------------------------------------------------------------------------


def leads_somewhere(document: Document, link: str) -> bool:
    target, _, fragment = link.partition("#")
    file = (document.file.parent / target).resolve() if target else document.file
    there = file.exists() and file.is_relative_to(ROOT)
    if there and fragment:
        return fragment in Document(file.relative_to(ROOT).as_posix()).anchors
    return there


def test_links_lead_somewhere() -> None:
    broken = [
        f"{document.path}: {link}"
        for document in OURS
        for link in document.links
        if not re.match(r"[a-z]+:", link) and not leads_somewhere(document, link)
    ]
    assert broken == []


def test_the_reader_of_the_readme_finds_every_document() -> None:
    reached, open_ = set(), ["README.md"]
    while open_:
        path = open_.pop()
        reached.add(path)
        for link in Document(path).links:
            target = link.partition("#")[0]
            file = ((ROOT / path).parent / target).resolve()
            if target.endswith(".md") and file.is_relative_to(ROOT):
                name = file.relative_to(ROOT).as_posix()
                open_ += [name] if name not in reached and name not in open_ else []
    assert {document.path for document in OURS} <= reached


# --- paths and commands ----------------------------------------------------------------------


def test_paths_exist() -> None:
    """In documents, and in backticks in programs: docstrings, comments, texts."""
    files = [PurePosixPath(path) for path in tracked()]
    there = {*files, *(folder for path in files for folder in path.parents)}
    tops = {path.parts[0] for path in files if len(path.parts) > 1}
    made = {PurePosixPath(path) for path in MADE.findall((ROOT / WALK).read_text("utf-8"))}
    texts = [each for each in documents() if not each.path.startswith("changelog.d/")]
    named = [(each.path, word) for each in texts for code in each.code for word in code.split()]
    pages = {path.name for path in files}
    lost = []
    for path in (path for path in tracked() if path.endswith(".py")):
        program = (ROOT / path).read_text("utf-8")
        named += [(path, span) for span in re.findall(r"`([^`\n]+)`", program)]
        words = re.findall(r"\b(?!NAME)[A-Z]+\.md\b", program)
        lost += [f"{path}: {word}" for word in words if word not in pages]
    for where, span in named:
        known = there | made if where == WALK else there
        if re.fullmatch(r"[\w.*-]+/[\w./*-]*", span) and PurePosixPath(span).parts[0] in tops:
            pattern = PLACEHOLDER.sub("*", span.strip("/"))
            ends = (pattern, f"{pattern}.md")  # as a toctree has it
            if not any(path.match(end) for path in known for end in ends) and not _is_ignored(span):
                lost.append(f"{where}: {span}")
    assert lost == []


def _is_ignored(path: str) -> bool:
    """Return whether git ignores the path: it is made when it is needed."""
    asked = ["git", "check-ignore", path, f"{path}/"]
    return subprocess.run(asked, cwd=ROOT, capture_output=True, check=False).returncode == 0


def test_make_targets_and_modules_exist() -> None:
    makefile = (ROOT / "Makefile").read_text("utf-8")
    targets = set(re.findall(r"(?m)^([a-z][a-z-]*):", makefile))
    wrong = []
    for document in OURS:
        for code in document.code:
            if code.startswith("make "):
                words = code.partition("#")[0].split()[1:]
                wrong += [f"{document.path}: make {word}" for word in words
                          if "=" not in word and word not in targets]  # fmt: skip
            wrong += [f"{document.path}: python -m {name}"
                      for name in re.findall(r"\bpython3? -m ([\w.]+)", code)
                      if not _can_be_run(name)]  # fmt: skip
    assert wrong == []


def _can_be_run(name: str) -> bool:
    spec = importlib.util.find_spec(name)
    if spec is None or spec.submodule_search_locations is None:
        return spec is not None
    return importlib.util.find_spec(f"{name}.__main__") is not None


def test_course_commands_and_their_options_exist() -> None:
    wrong = []
    for where, code in [(document.path, code) for document in OURS for code in document.code]:
        match = re.match(r"(?:\.venv/bin/)?course ([a-z][a-z-]*)(.*)", code)
        named = str(where) == "CHANGELOG.md" and what_replaces(shlex.split(code)[1:])
        if match is None or named:  # the changelog names what went
            continue
        command = cli.commands.get(match[1])
        if isinstance(command, click.Group) and match[2].strip():
            verb, _, rest = match[2].strip().partition(" ")
            command, asked_of = command.commands.get(verb), rest
        else:
            asked_of = match[2]
        if command is None:
            wrong.append(f"{where}: {code}")
            continue
        known = {name for parameter in command.params for name in parameter.opts} | {"--help"}
        asked = [word for word in shlex.split(asked_of, comments=True) if word.startswith("--")]
        wrong += [f"{where}: {code}: {word}" for word in asked if word not in known]
    assert wrong == []


def test_every_course_command_is_in_a_document() -> None:
    """And so is every `make` target: who reads on finds them all."""
    code = "\n".join(code for document in OURS for code in document.code)
    assert isinstance(cli, click.Group)
    assert [name for name in cli.commands if f"course {name}" not in code] == ["dataset"]
    documented = re.findall(r"(?m)^([a-z-]+):.*## ", (ROOT / "Makefile").read_text("utf-8"))
    unsaid = {name for name in documented if not re.search(rf"make {name}\b", code)}
    assert unsaid == {"help", "format", "clean"}


# --- what they say ---------------------------------------------------------------------------


def test_the_readme_lists_the_exercises() -> None:
    row = re.compile(r"(?m)^\| (\d+) \| \[(\w+)\]\(exercises/(\w+)/README\.md\) \| .+ \|$")
    rows = row.findall((ROOT / "README.md").read_text("utf-8"))
    wanted = [(str(e.number), e.slug, e.slug) for e in all_exercises()]
    assert rows == wanted, "a row for each exercise, in the order of their numbers"


def _said(pattern: str) -> int:
    """Return the number that the README says."""
    said = re.search(pattern, " ".join(Document("README.md").prose.split()))
    assert said is not None, pattern
    return int(said[1])


def test_the_notebooks_page_lists_each_of_them() -> None:
    page = (ROOT / "notebooks/README.md").read_text("utf-8")
    named = re.findall(r"(?m)^\| `(\w+)` \|", page)
    assert named == sorted(folder.name for folder in (ROOT / "notebooks/text").iterdir())


def test_the_proof_is_as_large_as_the_readme_says() -> None:
    count = sum(len(mutants(exercise)) for exercise in all_exercises())
    assert _said(r"More than (\d+) deliberately wrong solutions") == (count - 1) // 100 * 100


def test_exercise_1_is_simulated_for_as_long_as_the_readme_says() -> None:
    marks = [mark for each in vars(test_core).values() for mark in getattr(each, "pytestmark", ())]
    names = {name for mark in marks for name in mark.kwargs["scenarios"]}
    seconds = sum(load_scenario(name).duration for name in names)
    assert _said(r"the (\d+) simulated seconds of exercise 1") == round(seconds)


def test_no_document_knows_the_machine_it_was_written_on() -> None:
    home = str(Path.home())
    for document in documents():
        text = document.file.read_text("utf-8")
        assert "/work/" not in text
        assert home == "/" or f"{home}/" not in text
