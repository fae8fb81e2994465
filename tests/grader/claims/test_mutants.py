"""The catalogues of mutants: what they render to, and what is wrong with a wrong one."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from grader.authoring.mutants import main
from grader.claims.mutants import check_names, find_mutant, mutants, submission_of
from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.errors import InputError

HEAD = "base: variants/compact.py\n"
ENTRY = """
# A comment
mutant narrow fails sees_sides, field_lds01
Looks only ±45° ahead.
-AHEAD = 90
+AHEAD = 45
"""
COMPACT = '"""Right.\n\nfield: all\n"""  # noqa: E501\n\nAHEAD = 90\nif AHEAD:\n    print(AHEAD)\n'
RENDERED = '''"""Looks only ±45° ahead.


"""

AHEAD = 45
if AHEAD:
    print(AHEAD)
'''
EXERCISES = pytest.mark.parametrize("exercise", all_exercises(), ids=lambda one: one.slug)


@pytest.fixture
def exercise(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Exercise:
    """Exercise 1 with one variant, and one mutant of it."""
    monkeypatch.setattr("grader.course.exercises.SOLUTIONS", tmp_path)
    folder = tmp_path / "obstacle_avoidance"
    (folder / "variants").mkdir(parents=True)
    (folder / "variants" / "compact.py").write_text(COMPACT, "utf-8")
    (folder / "mutants.diff").write_text(HEAD + ENTRY, "utf-8")
    return find_exercise("obstacle_avoidance")


# --- those of the course --------------------------------------------------------------------------


@EXERCISES
def test_every_catalogue_renders_to_programs_that_say_what_they_are(exercise: Exercise) -> None:
    for mutant in mutants(exercise):
        doc = ast.get_docstring(ast.parse(mutant.text))
        assert doc is not None
        assert doc.splitlines()[0] == mutant.mistake, mutant.name
        listed = {
            key: set(values.split(", "))
            for key, values in (line.split(": ") for line in doc.splitlines()[2:])
        }
        assert listed.get("requires", set()) == mutant.requires
        assert listed.get("file", {exercise.files[0]}) == {mutant.file}
        assert mutant.fails <= check_names(exercise)


@EXERCISES
def test_no_two_mutants_are_one_program(exercise: Exercise) -> None:
    found = mutants(exercise)
    programs = {mutant.text.split('"""', 2)[2] for mutant in found}
    assert len(programs) == len(found)


# --- rendering ------------------------------------------------------------------------------------


def test_a_mutant_is_the_base_with_the_edit_and_a_docstring_of_its_own(exercise: Exercise) -> None:
    (mutant,) = mutants(exercise)
    assert mutant.text == RENDERED
    assert mutant.mistake == "Looks only ±45° ahead."
    assert mutant.fails == {"sees_sides", "field_lds01"}
    assert mutant.file == exercise.files[0]


def test_a_base_of_its_own_and_a_library(exercise: Exercise) -> None:
    (exercise.solutions / exercise.files[0]).write_text("AHEAD = 90\n", "utf-8")
    text = HEAD + ENTRY.replace("-A", f"base: {exercise.files[0]}\nrequires: torch, onnx\n-A")
    (exercise.solutions / "mutants.diff").write_text(text, "utf-8")
    (mutant,) = mutants(exercise)
    assert mutant.text.endswith('ahead.\n\nrequires: torch, onnx\n"""\nAHEAD = 45\n')
    assert mutant.requires == {"torch", "onnx"}


def test_a_mutant_of_the_second_file_says_so() -> None:
    exercise = find_exercise("model_server")
    mutant = find_mutant(exercise, "asks_once_a_second")
    assert mutant.file == "detection_client.py"
    assert "\nfile: detection_client.py\n" in mutant.text
    files = submission_of(exercise, mutant)
    assert files["detection_client.py"] == mutant.text
    server = exercise.solutions / "detection_server.py"
    assert files == {**files, "detection_server.py": server.read_text("utf-8")}


def test_a_fourth_mutant_of_a_check_says_why(
    exercise: Exercise, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("grader.authoring.mutants.all_exercises", lambda: [exercise])
    path = exercise.solutions / "mutants.diff"
    alone = ENTRY.replace(", field_lds01", "")  # the fifth fails another check, too
    entries = [
        entry.replace("narrow", f"narrow_{i}").replace("= 45", f"= {i}")
        for i, entry in enumerate([alone, alone, alone, alone, ENTRY])
    ]
    path.write_text(HEAD + "".join(entries), "utf-8")
    assert main(["--check"]) == 1
    (line,) = capsys.readouterr().out.splitlines()
    assert line.startswith(
        f"{path}: mutant.narrow_3: 3 mutants before it name sees_sides: say `why`"
    )
    entries[3] = entries[3].replace("-A", "why: Alone notices 60°.\n-A")
    path.write_text(HEAD + "".join(entries), "utf-8")
    assert main(["--check"]) == 0
    assert mutants(exercise)[3].why == "Alone notices 60°."


def test_without_a_catalogue_there_is_none(exercise: Exercise) -> None:
    (exercise.solutions / "mutants.diff").unlink()
    assert mutants(exercise) == []


# --- mistakes in a catalogue ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("variants/compact.py", "variants/compct.py", "mutant.narrow: no base 'variants/com"),
        (HEAD, "", "'': expected `base: FILE` above the first mutant"),
        (HEAD, f"{HEAD}bas: x\n", "bas: x': expected `base: FILE` above the first mutant"),
        (ENTRY, f"{ENTRY}{ENTRY}", "mutant.narrow is there twice"),
        ("fails", "fials", "mutant.narrow fials sees_sides, field_lds01.fails"),
        ("ahead.", "ahead.\nwy: x", "unknown key 'mutant.narrow.wy'; did you mean 'why'?"),
        ("ahead.", "ahead.\nAHEAD", "unknown key 'mutant.narrow.AHEAD'"),
        ("Looks only ±45° ahead.\n", "", "mutant.narrow.mistake"),
        (" sees_sides, field_lds01", " ", "mutant.narrow.fails"),
        ("sees_sides", "sees_side", "no check 'sees_side'; did you mean 'sees_sides'?"),
        ("-AHEAD = 90\n+AHEAD = 45\n", "", "mutant.narrow.edit"),
        ("-AHEAD = 90", "-AHEAD = 80", "mutant.narrow: hunk '-AHEAD = 80' fits 0 times in var"),
        ("-AHEAD = 90", "-AHEAD = 80", "the line nearest to 'AHEAD = 80' is 'AHEAD = 90'"),
        ("+AHEAD = 45", "+AHEAD = 90", "mutant.narrow: hunk '-AHEAD = 90' changes nothing"),
        ("+AHEAD = 45", "+AHEAD = = 45", "renders to no Python: invalid syntax: 'AHEAD = = 45'"),
    ],
)
def test_a_mistake_is_named(exercise: Exercise, old: str, new: str, message: str) -> None:
    path = exercise.solutions / "mutants.diff"
    text = HEAD + ENTRY
    assert old in text
    path.write_text(text.replace(old, new, 1), "utf-8")
    with pytest.raises(InputError) as caught:
        mutants(exercise)
    assert str(caught.value).startswith(f"{path}: ")
    assert message in str(caught.value)


# --- the command ----------------------------------------------------------------------------------


def test_the_command_lists_and_prints(
    exercise: Exercise, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["1"]) == 0
    assert capsys.readouterr().out == "narrow: Looks only ±45° ahead. [field_lds01, sees_sides]\n"
    assert main(["obstacle_avoidance", "narrow"]) == 0
    assert capsys.readouterr().out == RENDERED


def test_the_command_writes_a_submission_and_overwrites_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    exercise = find_exercise("ml_velocity")
    command = ["ml_velocity", "train_no_random_state", "--into", str(tmp_path / "wrong")]
    assert main(command) == 0
    written = {path.name: path.read_text("utf-8") for path in (tmp_path / "wrong").iterdir()}
    assert written == submission_of(exercise, find_mutant(exercise, "train_no_random_state"))
    with pytest.raises(SystemExit):
        main(command)
    assert "is there already; --force overwrites it" in capsys.readouterr().err
    assert main([*command, "--force"]) == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["obstacle_avoidanc"], "did you mean obstacle_avoidance?"),
        (["1", "narow"], "did you mean 'narrow'?"),
        (["1", "--into", "x"], "--into needs the name of a mutant"),
        ([], "expected an exercise, or --check"),
    ],
)
def test_the_command_says_what_is_wrong(
    exercise: Exercise, capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    assert stopped.value.code == 2
    assert message in capsys.readouterr().err


def test_a_reader_that_has_enough_ends_the_list_without_a_word() -> None:
    command = [sys.executable, "-m", "grader.authoring.mutants", "1"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as listing:
        assert listing.stdout and listing.stderr
        listing.stdout.close()
        assert listing.stderr.read() == b""


def test_no_mutant_dies_of_a_name_that_its_edit_removed(tmp_path: Path) -> None:
    for exercise in all_exercises():
        for mutant in mutants(exercise):
            (tmp_path / f"{exercise.slug}_{mutant.name}.py").write_text(mutant.text, "utf-8")
    ruff = [sys.executable, "-m", "ruff", "check", "--isolated", "--select", "F821", str(tmp_path)]
    done = subprocess.run(ruff, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
