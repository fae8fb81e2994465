"""Make the replays and the quoted texts of lessons/pitfalls: plausible nodes that fail, and why.

Each pitfall is a node in lessons/pitfalls/nodes that looks right but is not, with its corrected
version. Their tasks are smaller than the exercises' and different: the nodes are published, and
none of them should pass an exercise.

`python -m grader.authoring.pitfalls OUT` drives them and writes a replay of each into OUT, which
opens where the node goes wrong. `--made` writes lessons/pitfalls/made: the differences, the
replays' frames, and the grader's output for wrong solutions (solutions/*/mutants.diff) that make
the same mistakes. `--check` tells whether these are up to date.
"""

import difflib
import html
import re
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from grader.authoring import moments
from grader.authoring.moments import Moments
from grader.claims.mutants import find_mutant
from grader.course.exercises import ROOT, find_exercise
from grader.course.generated import CHECK, write_or_check
from grader.course.submission import find_submission
from grader.errors import GraderError, InputError
from grader.grading.grading import Grading, grade_submission
from grader.launchers import fork_server
from grader.recording import Recording
from grader.report.page import GENERATED_BY, page_html, replay_payload
from grader.report.terminal import printed
from grader.trial.virtual_time import run_trial
from rclpy_virtual_time import ForkServer
from sim.scenario_files import load_scenario

FOLDER = ROOT / "lessons" / "pitfalls"
NODES = FOLDER / "nodes"
MADE = FOLDER / "made"
MODES = ("--made", CHECK)
REPLAYS = "replays"  # their folder, relative to a page
WIDTH = 80  # [characters] of the grader's tables
LIBRARIES = re.compile(r"\S*/(?:site|dist)-packages/")  # their place differs by machine


# --- the pitfalls ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Pitfall:
    """A mistake: nodes that make it, a node that does not, and the checks that catch it."""

    name: str  # of its page
    wrong: tuple[str, ...]  # nodes
    right: str  # node
    exercise: str
    caught: Mapping[str, tuple[str, ...]]  # wrong solutions: the checks that its page quotes
    scenario: str  # in which it shows
    moments: Moments

    @property
    def nodes(self) -> tuple[str, ...]:
        """All of its nodes."""
        return (*self.wrong, self.right)

    def replay_of(self, node: str) -> str:
        """Return the name of a node's replay; pitfalls may share their right node."""
        return f"{self.name}_right" if node == self.right else node


def _read() -> tuple[Pitfall, ...]:
    table = tomllib.loads((FOLDER / "pitfalls.toml").read_text("utf-8"))
    return tuple(
        Pitfall(
            name,
            tuple(row["wrong"]),
            row["right"],
            row["exercise"],
            {mutant: tuple(checks) for mutant, checks in row["caught"].items()},
            row["scenario"],
            _moments(*row["moments"]),
        )
        for name, row in table.items()
    )


def _moments(name: str, *numbers: float) -> Moments:
    """Return the function of that name among the moments; with numbers, what it makes."""
    found = getattr(moments, name)
    made: Moments = found(*numbers) if numbers else found
    return made


PITFALLS = _read()


# --- replays --------------------------------------------------------------------------------------


def main(arguments: list[str]) -> int:
    """Write the replays, or the texts; with `--check` compare the texts, 1 if they differ."""
    if len(arguments) != 1 or (arguments[0].startswith("-") and arguments[0] not in MODES):
        raise InputError(f"expected a folder for the replays, or {' or '.join(MODES)}")
    with fork_server() as forkserver:
        if arguments[0] not in MODES:
            write_replays(Path(arguments[0]), forkserver)
            return 0
        texts = list(made(forkserver))
    command = "python -m grader.authoring.pitfalls --made"
    return write_or_check(texts, command, [CHECK] if arguments[0] == CHECK else [])


def write_replays(out: Path, forkserver: ForkServer) -> None:
    """Drive every node and write its replay."""
    out.mkdir(parents=True, exist_ok=True)
    for pitfall in PITFALLS:
        for node in pitfall.nodes:
            recording = drive(pitfall, node, forkserver)
            (out / f"{pitfall.replay_of(node)}.html").write_text(
                replay(pitfall, recording), "utf-8"
            )


def drive(pitfall: Pitfall, node: str, forkserver: ForkServer) -> Recording:
    """Run a node in the pitfall's scenario; the robot takes nothing but Twist."""
    submission = find_submission(NODES / f"{node}.py")
    return run_trial(submission, load_scenario(pitfall.scenario), forkserver)


def replay(pitfall: Pitfall, recording: Recording) -> str:
    """Return the replay as a page for an iframe; it opens at the first moment, if there is one."""
    moments = [moment.as_dict() for moment in pitfall.moments(recording)]
    shown = replay_payload(recording, moments)
    for line in shown["log"]:
        line["text"] = LIBRARIES.sub("", line["text"].replace(f"{ROOT}/", ""))
    shown["compute"] = []  # of this machine, and beside the page's point
    payload = {
        "grading": None, "replays": [shown], "title": shown["title"],
        "generated_by": GENERATED_BY, "embedded": True,
    }  # fmt: skip
    return page_html(payload)


# --- texts ----------------------------------------------------------------------------------------


def made(
    forkserver: ForkServer,
    pitfalls: Iterable[Pitfall] = PITFALLS,
    drive: Callable[[Pitfall, str, ForkServer], Recording] = drive,
) -> Iterator[tuple[Path, str]]:
    """Return every file of lessons/pitfalls/made with its text."""
    for pitfall in pitfalls:
        yield MADE / f"{pitfall.name}.diff", differences(pitfall.wrong[0], pitfall.right)
        for mutant, checks in pitfall.caught.items():
            grading = grade_mutant(mutant, forkserver, only=checks)
            yield MADE / f"{Path(mutant).name}.grade.txt", printed(grading.as_dict(), WIDTH)
        for node in pitfall.nodes:
            shown = frame(pitfall, drive(pitfall, node, forkserver), node)
            yield MADE / f"{pitfall.replay_of(node)}.frame.txt", shown


def grade_mutant(mutant: str, forkserver: ForkServer, *, only: Iterable[str] = ()) -> Grading:
    """Grade a wrong solution, `exercise/name`, by some checks or by all, as if it were handed in.

    Raises GraderError: the grader or the machine failed.
    """
    slug, _, name = mutant.partition("/")
    exercise = find_exercise(slug)
    wrong = find_mutant(exercise, name)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, wrong.file)
        file.write_text(wrong.text, "utf-8")
        return grade(slug, file, forkserver, only=only)


def grade(slug: str, path: Path, forkserver: ForkServer, *, only: Iterable[str] = ()) -> Grading:
    """Grade a node, by some checks or by all of the core.

    Raises GraderError: the grader or the machine failed.
    """
    only = tuple(only)
    grading = grade_submission(
        find_exercise(slug),
        find_submission(path),
        forkserver,
        file=path.name,
        field=any(check.startswith("field_") for check in only),
        only=only,
    )
    if grading.faulty:
        raise GraderError(f"{path.name} could not be judged; try again")
    return grading


def differences(wrong: str, right: str) -> str:
    """Return the correction of a wrong node, as a unified diff."""
    before, after = (
        (NODES / f"{node}.py").read_text("utf-8").splitlines(keepends=True)
        for node in (wrong, right)
    )
    return "".join(difflib.unified_diff(before, after, f"{wrong}.py", f"{right}.py", n=2))


def frame(pitfall: Pitfall, recording: Recording, node: str) -> str:
    """Return the HTML that shows a replay in a page, with a caption."""
    first = next(pitfall.moments(recording), None)
    what = "wrong" if node in pitfall.wrong else "right"
    title = f"Replay of {node}.py: {recording.scenario.title}"
    source = f"{REPLAYS}/{pitfall.replay_of(node)}.html"
    said = "The node put right, from the start."
    if first is not None:
        said = (
            f"Stopped at {first.t:.2f} s, where this fails: “{first.rule}” "
            f"Expected: {first.expected}. Actual: {first.actual}."
        )
    return (
        f'<figure class="replay is-{what}">\n'
        f'<iframe loading="lazy" title="{html.escape(title)}" src="{source}"></iframe>\n'
        f"<figcaption>{html.escape(said)}\n"
        f'<a href="{source}">Open it on a page of its own</a></figcaption>\n'
        "</figure>\n"
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
