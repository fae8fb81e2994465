"""The documents: their width and length, and that all they mention is there."""

from __future__ import annotations

import fnmatch
import importlib.util
import re
import shlex
from collections import defaultdict
from pathlib import Path, PurePosixPath

import click
import pytest
from documents import ROOT, Document, documents, tracked

from grader.authoring.mutants import mutants
from grader.cli import cli
from grader.course.exercises import all_exercises, find_exercise
from grader.course.submission import find_submission
from grader.grading.grading import grade_submission
from grader.link.hosts import ForkServer
from sim.messages import EPOCH_NS

COLUMNS = 100
LONGEST = {"README.md": 100, "CONTRIBUTING.md": 130, "SECURITY.md": 60}  # [lines]
OURS = documents(
    "README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "docs/", "notebooks/README.md"
)
# What nothing can break: options of MyST, a command in backticks, the target of a link
ONE_LINE = re.compile(r"\s*(:alt:|\+\+\+ \{|`[^`]*`\S*$|\S*\]\(https?://\S+$)")
OTHERS = ("text", "{code-cell}")  # fences whose lines are a program's
PLACEHOLDER = re.compile(r"\b(NAME|FILE|EXERCISE|FOLDER)\b|\*")
JOINED = re.compile(r'\bROOT((?: / "[^"*{]+")+)')
NAMED = re.compile(r"\b(?:grader|sim|solutions|tests)/[\w./-]+\.(?:py|toml|xml)\b")
WALK = "docs/add-an-exercise.md"  # its reader makes files of her own
THEIRS = {"my_agent.py", "file.py", "junit.xml"}  # what readers write, or get

each = pytest.mark.parametrize("document", OURS, ids=lambda document: document.path)
each_written = pytest.mark.parametrize("document", OURS, ids=lambda document: document.path)


# --- width and length ------------------------------------------------------------------------


@pytest.mark.parametrize(
    "document",
    documents(),
    ids=lambda document: document.path,
)
def test_lines_keep_to_100_columns(document: Document) -> None:
    wide = [
        f"{document.path}:{line.number}: {len(line.text)} columns"
        for line in document.lines
        if len(line.text) > COLUMNS
        and not line.in_table
        and line.fence not in OTHERS
        and not ONE_LINE.match(line.text)
    ]
    assert wide == []


@pytest.mark.parametrize("path", LONGEST)
def test_what_everybody_reads_is_short(path: str) -> None:
    assert len(Document(path).lines) <= LONGEST[path]


# --- links -----------------------------------------------------------------------------------


@each
def test_links_lead_somewhere(document: Document) -> None:
    broken = []
    for link in document.links:
        if re.match(r"[a-z]+:", link):
            continue
        target, _, fragment = link.partition("#")
        file = (document.file.parent / target).resolve() if target else document.file
        there = file.exists() and file.is_relative_to(ROOT)
        if there and fragment:
            there = fragment in Document(file.relative_to(ROOT).as_posix()).anchors
        broken += [] if there else [link]
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


def test_every_picture_is_shown() -> None:
    shown = {
        (document.file.parent / link).resolve() for document in OURS for link in document.links
    }
    pictures = [ROOT / path for path in tracked() if path.startswith("docs/images/")]
    assert [path for path in pictures if path not in shown] == []


# --- paths and commands ----------------------------------------------------------------------


@pytest.mark.parametrize(
    "document",
    [*OURS, *documents("solutions/", "exercises/")],
    ids=lambda document: document.path,
)
def test_paths_exist(document: Document) -> None:
    """A path is there; a bare file name is in the top folder or in one that the document names."""
    files = [PurePosixPath(path) for path in tracked()]
    there = {str(path) for path in files} | {str(p) for path in files for p in path.parents}
    tops = {path.parts[0] for path in files if len(path.parts) > 1}
    if document.path == WALK:
        there |= _made_by_the_walk()
    spans = [span for span in document.spans if re.fullmatch(r"[\w./*-]+", span)]
    folders = {str(PurePosixPath(document.path).parent), "."}
    for span in spans:
        if span.endswith("/"):
            pattern = PLACEHOLDER.sub("*", span.strip("/"))
            folders |= {path for path in there if fnmatch.fnmatch(path, pattern)}
    lost = []
    for span in spans:
        path = PLACEHOLDER.sub("*", span.strip("/"))
        if "/" in span and PurePosixPath(span).parts[0] in tops:
            found = path in there or any(PurePosixPath(one).match(path) for one in there)
        elif path.endswith((".py", ".toml", ".js", ".xml")) and "*" not in path:
            beside = {str(PurePosixPath(folder) / path) for folder in folders}
            found = path in THEIRS or not beside.isdisjoint(there)
        else:
            continue
        lost += [] if found else [span]
    assert lost == []


def test_paths_in_programs_exist() -> None:
    """A path that a program puts together from ROOT, or a file of settings names, is there."""
    lost = []
    for path in tracked():
        text = (ROOT / path).read_text("utf-8") if path.endswith((".py", ".toml")) else ""
        named = {"/".join(re.findall(r'"([^"]+)"', parts)) for parts in JOINED.findall(text)}
        named |= set(NAMED.findall(text)) if path.endswith(".toml") else set()
        lost += [f"{path}: {name}" for name in sorted(named) if not (ROOT / name).exists()]
    assert lost == []


def _made_by_the_walk() -> set[str]:
    return set(re.findall(r"(?m)^`([\w./-]+)`", (ROOT / WALK).read_text("utf-8")))


@each
def test_make_targets_exist(document: Document) -> None:
    makefile = (ROOT / "Makefile").read_text("utf-8")
    targets = set(re.findall(r"(?m)^([a-z][a-z-]*):", makefile))
    asked = {
        word
        for code in document.code
        if code.startswith("make ")
        for word in code.partition("#")[0].split()[1:]
        if "=" not in word
    }
    assert asked - targets == set()


@each
def test_modules_that_are_run_exist(document: Document) -> None:
    asked = {name for code in document.code for name in re.findall(r"\bpython3? -m ([\w.]+)", code)}
    missing = [name for name in sorted(asked) if not _can_be_run(name)]
    assert missing == []


def _can_be_run(name: str) -> bool:
    spec = importlib.util.find_spec(name)
    if spec is None or spec.submodule_search_locations is None:
        return spec is not None
    return importlib.util.find_spec(f"{name}.__main__") is not None


@each
def test_course_commands_and_their_options_exist(document: Document) -> None:
    wrong = []
    for code in document.code:
        match = re.match(r"(?:\.venv/bin/)?course ([a-z][a-z-]*)(.*)", code)
        if match is None:
            continue
        command = cli.commands.get(match[1])
        if isinstance(command, click.Group) and match[2].strip():
            verb, _, rest = match[2].strip().partition(" ")
            command, asked_of = command.commands.get(verb), rest
        else:
            asked_of = match[2]
        if command is None:
            wrong.append(code)
            continue
        known = {name for parameter in command.params for name in parameter.opts} | {"--help"}
        asked = [word for word in shlex.split(asked_of, comments=True) if word.startswith("--")]
        wrong += [f"{code}: {word}" for word in asked if word not in known]
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
    row = re.compile(r"\| (\d+) \| \[(\w+)\]\(exercises/(\w+)/README\.md\) \| (.+) \|")
    rows = [
        match.groups() for line in Document("README.md").lines if (match := row.match(line.text))
    ]
    assert [(number, name, folder) for number, name, folder, _ in rows] == [
        (str(exercise.number), exercise.slug, exercise.slug) for exercise in all_exercises()
    ]


def _said(pattern: str) -> int:
    """Return the number that the README says."""
    said = re.search(pattern, " ".join(Document("README.md").prose.split()))
    assert said is not None, pattern
    return int(said[1])


def test_the_proof_is_as_large_as_the_readme_says() -> None:
    count = sum(len(mutants(exercise)) for exercise in all_exercises())
    assert _said(r"More than (\d+) deliberately wrong solutions") == (count - 1) // 100 * 100


def test_exercise_1_is_simulated_for_as_long_as_the_readme_says() -> None:
    exercise = find_exercise("1")
    (file,) = exercise.files
    submission = find_submission(exercise.solutions / file, file, ())
    with ForkServer(EPOCH_NS) as forkserver:
        grading = grade_submission(exercise, submission, forkserver, file=file)
    assert grading.score == 100  # as the quoted output says
    seconds = sum(recording.scenario.duration for recording in grading.recordings)
    assert _said(r"the (\d+) simulated seconds of exercise 1") == round(seconds)


def test_no_sentence_stands_twice() -> None:
    """A fact has one home; the other documents link to it."""
    places: dict[str, list[str]] = defaultdict(list)
    for document in OURS:
        for sentence in document.sentences():
            words = re.findall(r"\w+", sentence.lower())
            if len(words) >= 6:
                places[" ".join(words)].append(document.path)
    assert {sentence: where for sentence, where in places.items() if len(where) > 1} == {}


def test_no_document_knows_the_machine_it_was_written_on() -> None:
    home = str(Path.home())
    for document in documents():
        text = document.file.read_text("utf-8")
        assert "/work/" not in text
        assert home == "/" or f"{home}/" not in text
