"""What a student's file does to its reader costs that student alone, with a reason."""

import re
import resource
from collections.abc import Iterator

import pytest
from hostile_files import AGENT, FILES

from grader.classroom.intake.handed_in import Student
from grader.classroom.intake.students import take_in

pytestmark = pytest.mark.long
MIB = 2**20
HONEST = "import rclpy\n"


@pytest.fixture(scope="module")
def students(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Student]]:
    """A class of hostile files and one honest one, by name."""
    folder = tmp_path_factory.mktemp("hostile")
    (folder / "in").mkdir()
    for number, (suffix, made, _) in enumerate(FILES.values()):
        if suffix == ".ipynb":
            (folder / "in" / f"s{number}").mkdir()
            (folder / "in" / f"s{number}" / "n.ipynb").write_bytes(made())
        else:
            (folder / "in" / f"s{number}{suffix}").write_bytes(made())
    (folder / "in" / "zoe").mkdir()
    (folder / "in" / "zoe" / AGENT).write_text(HONEST)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    taken = {
        student.id: student for student in take_in([folder / "in"], folder / "scratch").students
    }
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    assert after - before < 100 * MIB
    assert [file.path.read_text() for file in taken["zoe"].files] == [HONEST]
    assert not list(folder.parent.rglob("evil.py"))
    yield {name: taken[f"s{number}"] for number, name in enumerate(FILES)}


@pytest.mark.parametrize("name", FILES)
def test_a_hostile_file_is_refused_with_a_reason_or_taken(
    students: dict[str, Student], name: str
) -> None:
    problem, student = FILES[name][2], students[name]
    if problem:
        assert re.search(problem, student.problem), student.problem
    else:
        assert student.problem == ""
    assert student.links == ("link" in name)
    assert len(student.problem) < 1_000
    assert student.problem.isprintable()
    assert all(file.path.is_file() and not file.path.is_symlink() for file in student.files)
