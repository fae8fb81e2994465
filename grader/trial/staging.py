"""What a trial starts with: the files in the node's working folder, its programs, the topics."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

from grader.course.submission import Program, Submission
from grader.models.files import write_models
from rclpy_virtual_time import Offer, ProgramStart
from sim.messages import LATCHED
from sim.scenario import ProgramSpec, Scenario
from sim.sensors import OFFERED, SENSOR_TOPICS

# rcl reads sections in the order in which their names are first mentioned, and in one of them a
# value of another type may win. This one is for every node, and nobody else has it: it comes last.
LAST = "/**/**/**"
LAST_FILE = ".course_params_{}.yaml"  # hidden files of a submission never come along
# programs of ours that run beside students'
SUPPLIED = Path(__file__).parents[1] / "hosted" / "supplied"


@dataclass(frozen=True)
class Stage:
    """A folder with everything in it, and what to run there."""

    folder: Path
    programs: tuple[ProgramStart, ...]
    offers: tuple[Offer, ...]
    called: list[str]  # the programs: the exercise's files that they are, or their own


@contextlib.contextmanager
def stage(
    submission: Submission,
    scenario: Scenario,
    arguments: Sequence[str] = (),
    files: Mapping[str, bytes] | None = None,
) -> Iterator[Stage]:
    """Lay out a submission for a scenario, in a fresh folder that goes when the block ends."""
    made = dict(each for program in _read_out(submission) for each in program.made)
    ours = _ours(scenario, {*made, *(files or {})})
    with submission.folder(without=ours) as folder:
        write_models(scenario.node.models, folder)
        for name, text in made.items():
            (folder / name).write_text(text, "utf-8")
        for name, content in (files or {}).items():
            (folder / name).write_bytes(content)
        called, programs = _programs(scenario, submission, folder, arguments)
        yield Stage(folder, programs, _offers(scenario), called)


def missing_file(scenario: Scenario, submission: Submission) -> str:
    """Say which of the scenario's programs the submission lacks; empty if none."""
    there = [path.name for path in (submission.path, *submission.others)]
    for spec in scenario.program:
        known = submission.package is not None or spec.file in ("", *there)
        if spec.supplied or (known and submission.started(spec.file)):
            continue
        if spec.file in there:
            return f"no entry point of the package leads to {spec.file}"
        return f"there is no {spec.file} in the submission, only {', '.join(there)}"
    return ""


def parameter_arguments(parameters: Mapping[str, str | bool | int | float]) -> list[str]:
    """Return the command line that sets ROS parameters."""
    if not parameters:
        return []
    texts = {
        name: str(value).lower() if isinstance(value, bool) else str(value)
        for name, value in parameters.items()
    }
    flags = [word for name, text in texts.items() for word in ("-p", f"{name}:={text}")]
    return ["--ros-args", *flags]


def _programs(
    scenario: Scenario, submission: Submission, folder: Path, arguments: Sequence[str]
) -> tuple[list[str], tuple[ProgramStart, ...]]:
    """Return the programs to run: the submission's own file, or the scenario's; and their names."""
    own = parameter_arguments(scenario.node.parameters)
    for spec in scenario.program:
        if spec.supplied:
            shutil.copyfile(SUPPLIED / spec.file, folder / spec.file)
    programs: list[ProgramStart] = []
    called: list[str] = []
    for spec in scenario.program or (ProgramSpec(),):
        group = [Program(spec.file)] if spec.supplied else submission.started(spec.file)
        called += [submission.plays(program) for program in group]
        asked = spec.arguments if spec.supplied else (*own, *spec.arguments, *arguments)
        programs += [
            ProgramStart(
                file=str(folder / program.file),
                entry=program.entry,
                arguments=(*program.arguments, *asked, *_last(program, asked, folder, number)),
                start=round(spec.start * 1e9),
                stop=None if spec.stop is None else round(spec.stop * 1e9),
                hides=scenario.node.hides,
                spared=len(group) > 1 and not program.needed,
                asked=None if spec.supplied else _parameters(asked),
            )
            for number, each in enumerate(group, len(programs))
            for program in [_played(scenario.node.stand_in, submission, each, folder)]
        ]
    return called, tuple(programs)


def _played(stand_in: str, submission: Submission, program: Program, folder: Path) -> Program:
    """Return the program; where there is a stand-in, that, under the program's name."""
    if not stand_in:
        return program
    name = Path(submission.plays(program)).name
    shutil.copyfile(SUPPLIED / stand_in, folder / name)
    return replace(program, file=name, entry="")


def _read_out(submission: Submission) -> tuple[Program, ...]:
    return submission.package.programs if submission.package else ()


def _parameters(words: Sequence[str]) -> dict[str, str]:
    given = (word.partition(":=") for flag, word in pairwise(words) if flag == "-p")
    return {name: value for name, _, value in given}


def _last(program: Program, asked: Sequence[str], folder: Path, number: int) -> tuple[str, ...]:
    """Return words that let the parameters in `asked` win over all that goes before them."""
    given = _parameters(asked)
    if not given or not (program.arguments or "--params-file" in asked):
        return ()
    lines = [f"    {name}:\n      {value}" for name, value in given.items()]
    file = folder / LAST_FILE.format(number)
    file.write_text("\n".join([f"{LAST}:", "  ros__parameters:", *lines, ""]), "utf-8")
    return ("--ros-args", "--params-file", str(file))


def _ours(scenario: Scenario, files: Collection[str]) -> set[str]:
    """Return the names of files that the scenario puts into the folder, or keeps out of it."""
    named = {value for value in scenario.node.parameters.values() if isinstance(value, str)}
    supplied = {spec.file for spec in scenario.program if spec.supplied}
    return {*named, *scenario.node.models, *supplied, *files}


def _offers(scenario: Scenario) -> tuple[Offer, ...]:
    reliable = scenario.qos.sensors == "reliable"
    return tuple(
        Offer(topic, type, reliable or topic not in SENSOR_TOPICS, topic in LATCHED)
        for topic, type in OFFERED.items()
    )
