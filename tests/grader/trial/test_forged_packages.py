"""A forged answer of a package places nothing outside, and is no fault of the grader's."""

from pathlib import Path

import msgspec
import pytest
from laid_packages import MINE, lay

from grader.colcon.frames import Executable, Launched, PackageRead
from grader.course.submission import Package, find_submission
from grader.trial.packages import _with_programs


@pytest.mark.parametrize(
    "answer",
    [
        {"files": {"../out.py": "setup.py"}},
        {"files": {"/tmp/out.py": "setup.py"}},
        {"files": {"mine/one.py": "../../secret"}},
        {"files": {"mine/one.py": "/etc/passwd"}},
        {"files": {".git/hooks/x": "setup.py"}},
    ],
)
def test_a_forged_answer_places_nothing_outside(answer: dict[str, object], tmp_path: Path) -> None:
    submission = find_submission(lay(tmp_path, MINE))
    read = PackageRead(
        executables=(Executable("one", "mine/one.py", "mine.one:main"),),
        launched=(Launched("one", ()),),
        **answer,  # type: ignore[arg-type]
    )
    made = _with_programs(submission, Package(), "", read)
    assert made.problem
    assert set(made.beside) <= set(submission.beside)


ONE = {"mine/one.py": "mine/one.py"}


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"x": "setup.py", "x/y": "setup.py"}, ()),
        ({"mine": "setup.py"}, ()),  # a folder of its own
        ({"": "setup.py"}, ()),
        ({"./x": "setup.py", "é" * 150: "setup.py"}, ()),  # longer than a name can be
        ({}, ("é" * 20_000,) * 100),  # more than a frame of the judge's takes
    ],
)
def test_a_forged_answer_is_no_fault_of_the_graders(
    more: dict[str, str], words: tuple[str, ...], tmp_path: Path
) -> None:
    submission = find_submission(lay(tmp_path, MINE))
    one = (Executable("one", "mine/one.py", "mine.one:main"),)
    read = PackageRead(files=ONE | more, executables=one, launched=(Launched("one", words),))
    made = _with_programs(submission, Package(), "a_launch.py", read)
    if made.problem:
        return
    with made.folder() as folder:
        assert (folder / "mine" / "one.py").is_file()
    assert sum(len(word.encode()) for p in made.started() for word in p.arguments) < 2**20


def test_a_forged_note_draws_nothing_on_a_terminal(tmp_path: Path) -> None:
    submission = find_submission(lay(tmp_path, MINE))
    read = PackageRead(
        files={"mine/one.py": "mine/one.py"},
        executables=(Executable("one", "mine/one.py", "mine.one:main"),),
        notes=("\x1b[2J", "rviz2 is not started here"),
    )
    made = _with_programs(submission, Package(main="one.py"), "", read)
    assert (made.problem, made.left) == ("", ("rviz2 is not started here",))


@pytest.mark.parametrize("name", ["../launch_params_1.yaml", "/launch_params_1.yaml", "node.py"])
def test_what_a_launch_file_writes_has_a_name_of_the_hosts(name: str) -> None:
    def read(file: str) -> PackageRead:
        started = Launched("talker", (), made={file: "text"})
        answer = msgspec.msgpack.encode(PackageRead(launched=(started,)))
        return msgspec.msgpack.decode(answer, type=PackageRead)

    assert read("launch_params_1.yaml")
    with pytest.raises(msgspec.ValidationError):
        read(name)
