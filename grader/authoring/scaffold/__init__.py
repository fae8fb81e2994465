"""Make a new exercise: a small one that is graded and proven, in all the places of an exercise.

The templates lie in `files/`, each at the place that it makes; `SLUG` and `NOTEBOOK` in a path and
`{{words}}` in a text are filled in. Where the course lists its exercises, the new one is added.
What is generated is generated.
"""

import difflib
import importlib.util
import keyword
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from grader.course.exercises import ROOT, all_exercises
from grader.errors import GraderError, InputError

FILES = Path(__file__).resolve().parent / "files"
SUFFIX = ".in"
NAME = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*")
DEVICE = re.compile(r"con|prn|aux|nul|(com|lpt)\d")
LONGEST = 20  # [characters] of a name, so that lines stay within 100
SKELETONS = "grader.course.skeletons"  # writes what is generated of it


@dataclass
class Made:
    """A new exercise in the tree."""

    slug: str
    number: int
    new: list[Path] = field(default_factory=list)  # relative to the course
    edited: list[Path] = field(default_factory=list)


def scaffold(name: str, root: Path = ROOT) -> Made:
    """Make an exercise of that name; return what was made.

    Nothing is written if something is in its way; git takes the rest back.

    Raises InputError: the name will not do or is taken, or this is no checkout.
    Raises GraderError: what is generated could not be made.
    """
    _check(name, root)
    number = max(exercise.number for exercise in all_exercises()) + 1
    made = Made(name, number)
    words = _words(name, number)
    new, edited = dict(_files(words)), dict(_edits(words, root))
    for path in new:
        if (root / path).exists():
            raise InputError(f"{path} is there already; choose another name")
    for path in new | edited:
        if (root / path).resolve() != root.resolve() / path:
            raise InputError(
                f"{path}: expected no link there; it leads to {(root / path).resolve()}"
            )
    for path, text in (new | edited).items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(text, "utf-8")
    made.new += new
    made.edited += edited
    _generate(made, root)
    return made


def _check(name: str, root: Path) -> None:
    if not (root / "solutions").is_dir() or not (root / "pyproject.toml").is_file():
        raise InputError(f"{root}: expected a checkout of the course, with solutions/ in it")
    if DEVICE.fullmatch(name):
        raise InputError(f"{name!r}: a device's name on Windows; expected another, {name}_1 say")
    if keyword.iskeyword(name):
        raise InputError(f"{name!r}: a word of Python's own; expected another name, {name}_1 say")
    if not NAME.fullmatch(name) or len(name) > LONGEST:
        raise InputError(
            f"{name!r}: expected a name such as give_way: small letters, digits and single "
            f"underscores, at most {LONGEST} characters"
        )
    near = difflib.get_close_matches(name, [e.slug for e in all_exercises()], n=1, cutoff=0.9)
    if near:
        raise InputError(f"{name!r} is too close to the exercise {near[0]}; choose another name")
    taken = [
        *(root / "sim" / "scenarios").rglob("*.toml"),
        *(root / "grader" / "exercises").rglob("*.toml"),
        *(root / "grader").rglob("*.py"),  # no code names an exercise
    ]
    for path in taken:
        if path.stem in {name, f"{name}_ahead", f"{name}_best_effort"}:
            raise InputError(
                f"{name!r}: {path.relative_to(root)} is called so; choose another name"
            )
    if importlib.util.find_spec(name) is not None or name in sys.stdlib_module_names:
        raise InputError(f"{name!r} is a module of Python's or a library's; choose another name")


def _words(name: str, number: int) -> dict[str, str]:
    return {
        "slug": name,
        "title": name.replace("_", " ").capitalize(),
        "class": "".join(part.capitalize() for part in name.split("_")),
        "number": str(number),
        "notebook": f"{number:02}_{name}",
    }


# --- files of its own ----------------------------------------------------------------------------


def _files(words: Mapping[str, str]) -> Iterator[tuple[Path, str]]:
    """Yield the new files, relative to the course, with their texts."""
    for template in sorted(FILES.rglob(f"*{SUFFIX}")):
        place = template.relative_to(FILES).as_posix().removesuffix(SUFFIX)
        place = place.replace("SLUG", words["slug"]).replace("NOTEBOOK", words["notebook"])
        yield Path(place), filled(template.read_text("utf-8"), words)


def filled(text: str, words: Mapping[str, str]) -> str:
    """Return a template with its words.

    Raises GraderError: it has one that nobody knows.
    """
    try:
        return re.sub(r"\{\{(\w+)\}\}", lambda match: words[match[1]], text)
    except KeyError as error:
        raise GraderError(f"a template of a new exercise has an unknown word {error}") from None


# --- where exercises are listed ------------------------------------------------------------------

# file, what the new text stands behind (the last match counts), the new text
LISTS = (
    (
        "README.md",
        r"^\| \d+ \| \[\w+\]\(exercises/.*\n",
        "| {{number}} | [{{slug}}](exercises/{{slug}}/README.md) | stop at a line |\n",
    ),
    (
        "lessons/exercises/index.md",
        r"^\| \d+ \| \[.*/README\.md\).*\n",
        "| {{number}} | [{{title}}]({{slug}}/README.md) | stop at a line | 0.5 | "
        "[The structure of an agent node](../node.md) |\n",
    ),
    ("lessons/exercises/index.md", r"^\w+/README\n", "{{slug}}/README\n"),
    (
        "notebooks/README.md",
        r"^\| `\d+_.*\n",
        "| `{{notebook}}` | {{number}} | 100 |\n",
    ),
    (
        "lessons/node.md",  # the section "Exercise" is its last
        r"\Z",
        "\n[Exercise {{number}} · {{title}}](../exercises/{{slug}}/README.md): stop at a line.\n",
    ),
)  # fmt: skip


def _edits(words: Mapping[str, str], root: Path) -> Iterator[tuple[Path, str]]:
    """Yield the files that list the exercises, with the new one added."""
    texts: dict[str, str] = {}
    for name, behind, new in LISTS:
        text = texts.get(name) or (root / name).read_text("utf-8")
        places = list(re.finditer(behind, text, re.MULTILINE))
        if not places:
            raise GraderError(f"{name}: no place for a new exercise: expected {behind!r}")
        end = places[-1].end()
        texts[name] = text[:end] + filled(new, words) + text[end:]
    for name, text in texts.items():
        yield Path(name), text


# --- what is generated ---------------------------------------------------------------------------


def _generate(made: Made, root: Path) -> None:
    """Make what is generated: the skeleton."""
    made.new.append(Path("exercises") / made.slug / f"{made.slug}_agent.py")
    done = subprocess.run(
        [sys.executable, "-m", SKELETONS],
        cwd=root, capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode:
        last = (done.stdout + done.stderr).strip().splitlines() or ["no words"]
        raise GraderError(f"python -m {SKELETONS}: {last[-1]}")
