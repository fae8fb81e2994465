"""Which file is the submission, and what is wrong with it before it runs."""

import os
from pathlib import Path

import pytest

from grader.course import beside
from grader.course.submission import MAX_SIZE, Submission, find_submission, read_regular_file
from grader.errors import InputError


@pytest.fixture
def agent(tmp_path: Path) -> Path:
    file = tmp_path / "agent.py"
    file.write_text("print('hello')\n")
    return file


def refused(path: Path, expected: str | None = None) -> str:
    with pytest.raises(InputError) as caught:
        find_submission(path, expected)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("agent.py", None),
        ("agent.py", "other.py"),  # a file of another name will do
        (".", "agent.py"),
        ("link.py", None),
    ],
)
def test_a_file_a_folder_or_a_link_of_ones_own(
    agent: Path, given: str, expected: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    agent.with_name("link.py").symlink_to(agent)
    assert find_submission(agent.parent / given, expected).path == agent
    monkeypatch.chdir(agent.parent)
    assert find_submission(Path(given), expected).path == agent


def test_files_beside_it_belong_to_it(agent: Path) -> None:
    other = agent.with_name("client.py")
    other.write_text("pass")
    submission = find_submission(agent.parent, "agent.py", ("client.py", "absent.py"))

    assert submission.others == (other,)
    with submission.folder() as folder:
        assert sorted(file.name for file in folder.iterdir()) == ["agent.py", "client.py"]


@pytest.mark.parametrize("given", ["server.py", "client.py"])
def test_any_of_several_files_may_be_given(given: str, tmp_path: Path) -> None:
    for name in ("server.py", "client.py", "unrelated.py"):
        (tmp_path / name).write_text("pass")
    submission = find_submission(tmp_path / given, "server.py", ("client.py",))

    assert submission.path.name == given
    assert {given, *(path.name for path in submission.others)} == {"server.py", "client.py"}
    assert len(submission.others) == 1


def test_a_copy_is_ones_own_and_gone_afterwards(agent: Path) -> None:
    with Submission(agent).folder() as one, Submission(agent).folder() as two:
        assert one != two
        assert (one / "agent.py").read_text() == agent.read_text()
        (one / "new.txt").touch()
    assert not one.exists()
    assert agent.exists()


@pytest.mark.parametrize(
    ("given", "expected", "said"),
    [
        ("absent.py", None, "no such file"),
        ("to_nothing.py", None, "no such file"),
        (".", "seeker.py", "expected a file seeker.py in this folder; it holds agent.py"),
        ("empty", "seeker.py", "it holds no Python file"),
        (".", None, "this is a folder"),
        ("of_that_name", "agent.py", "expected a file agent.py"),
        ("pipe.py", None, "not a regular file"),
    ],
)
def test_what_is_no_submission(agent: Path, given: str, expected: str | None, said: str) -> None:
    folder = agent.parent
    (folder / "to_nothing.py").symlink_to(folder / "absent.py")
    (folder / "empty").mkdir()
    (folder / "of_that_name" / "agent.py").mkdir(parents=True)
    os.mkfifo(folder / "pipe.py")
    assert said in refused(folder / given, expected)


@pytest.mark.parametrize("name", [b"caf\xe9.py", b"a\nb.py", b"a\x1b[31m.py"])
def test_a_name_that_can_not_be_shown(name: bytes, tmp_path: Path) -> None:
    path = Path(os.fsdecode(os.fsencode(tmp_path) + b"/" + name))
    path.write_text("pass")
    assert refused(path).isprintable()


@pytest.mark.parametrize("name", ["grüß.py", "node with spaces.py", "no_suffix", "-.py", "节点.py"])
def test_other_names_are_fine(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text("pass")
    submission = find_submission(tmp_path / name)

    assert submission.problem == ""
    with submission.folder() as folder:
        assert (folder / name).is_file()


@pytest.mark.skipif(os.getuid() == 0, reason="root can read everything")
def test_a_file_that_can_not_be_read(agent: Path) -> None:
    agent.chmod(0)
    assert "cannot be read" in refused(agent)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"", "the file is empty: was it saved?"),
        (b"\n \t\r\n", "the file is empty: was it saved?"),
        (b"#" * (MAX_SIZE + 1), "the file has 1,048,577 bytes; at most 1,048,576 are read"),
        (b"#" * MAX_SIZE, ""),
        (b"\xff", "line 1 has a letter that is not UTF-8; save the file as UTF-8 in your editor"),
        (b"def f(:", ""),
    ],
)
def test_problems_are_the_students(content: bytes, problem: str, agent: Path) -> None:
    agent.write_bytes(content)
    assert find_submission(agent).problem == problem


def test_a_sparse_file_is_not_read(agent: Path) -> None:
    os.truncate(agent, 10**12)
    assert "1,000,000,000,000 bytes" in find_submission(agent).problem


# --- links: nobody's file but the one that was handed in ---------------------------------------


@pytest.fixture
def ben(tmp_path: Path) -> Path:
    """A folder of Ben's; beside it Ada's, with an answer, and a secret of the instructor's."""
    for name, text in (("ada/agent.py", "ada"), ("ada/client.py", "ada"), ("secret.txt", "word")):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    (tmp_path / "ben").mkdir()
    return tmp_path / "ben"


@pytest.mark.parametrize(
    "target", ["../ada/agent.py", "../ada", "../secret.txt", "../nothing", "agent.py"]
)
def test_a_link_in_a_folder_is_refused(target: str, ben: Path) -> None:
    (ben / "agent.py").symlink_to(target)
    said = refused(ben, "agent.py")
    assert "agent.py: a link, which is not followed" in said
    assert "ada/" not in said
    assert "word" not in said


@pytest.mark.parametrize("given", [".", "agent.py"])
def test_a_link_beside_the_file_is_refused(given: str, ben: Path) -> None:
    (ben / "agent.py").write_text("ben")
    (ben / "client.py").symlink_to("../ada/client.py")
    with pytest.raises(InputError, match=r"client\.py: a link"):
        find_submission(ben / given, "agent.py", ("client.py",))


def test_a_link_of_ones_own_to_a_file_or_a_folder_is_followed(ben: Path) -> None:
    (ben / "agent.py").write_text("ben")
    (ben / "client.py").write_text("ben, too")
    folder = ben.parent / "mine"
    folder.symlink_to(ben, target_is_directory=True)
    submission = find_submission(folder, "agent.py", ("client.py",))
    with submission.folder() as copy:
        assert (copy / "agent.py").read_text() == "ben"
        assert (copy / "client.py").read_text() == "ben, too"


def test_what_becomes_a_link_after_it_was_found_is_not_copied(ben: Path) -> None:
    for name in ("agent.py", "client.py"):
        (ben / name).write_text("ben")
    submission = find_submission(ben, "agent.py", ("client.py",))
    (ben / "client.py").unlink()
    (ben / "client.py").symlink_to("../ada/client.py")
    with pytest.raises(OSError), submission.folder():
        pytest.fail("copied")


@pytest.mark.parametrize("kind", ["pipe", "folder", "device"])
def test_what_is_no_file_is_not_opened(kind: str, tmp_path: Path) -> None:
    path = Path("/dev/zero") if kind == "device" else tmp_path / "x"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    with pytest.raises(OSError):
        read_regular_file(path)


# --- what lies beside it ------------------------------------------------------------------------


def test_what_comes_along_has_limits(agent: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = agent.parent
    for name in (
        "helper.py", "kit/__init__.py", "kit/a.yaml", "model.onnx", "notes.md", ".git/config",
        "venv/lib/x.py", "made/COLCON_IGNORE", "made/x.py", "env/pyvenv.cfg", "env/x.py",
    ):  # fmt: skip
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text("x")
    (folder / "link.py").symlink_to("/etc/passwd")
    (folder / "other").symlink_to("/etc", target_is_directory=True)
    os.truncate(folder / "model.onnx", beside.MAX_BYTES)
    (folder / "long.py").touch()
    os.truncate(folder / "long.py", beside.MAX_PYTHON + 1)

    submission = find_submission(agent)
    assert set(submission.files) == {"agent.py", "helper.py", "kit/__init__.py", "kit/a.yaml"}
    left = "; ".join(submission.left)
    for name in ("link.py, other (links", "long.py (over", "model.onnx (over the limits"):
        assert name in left
    assert submission.account()[0] == "With the node came helper.py, kit/__init__.py, kit/a.yaml."
    monkeypatch.setattr(beside, "MAX_FILES", 2)
    assert set(find_submission(agent).beside) == {"helper.py"}  # Python first, the node among it


def test_a_pointer_of_git_lfs_is_told_from_a_model(tmp_path: Path) -> None:
    (tmp_path / "agent.py").write_text("pass\n")
    (tmp_path / "real.onnx").write_bytes(b"\x08\x08model")
    pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n"
    (tmp_path / "policy.onnx").write_text(pointer)
    came, pointers = find_submission(tmp_path / "agent.py").account()
    assert came == "With the node came policy.onnx, real.onnx."
    assert pointers.startswith("policy.onnx: only a Git LFS pointer")
    assert "`git lfs pull`" in pointers


def test_the_catalogues_of_a_solution_of_the_courses_own_stay_behind() -> None:
    folder = Path(__file__).parents[3] / "solutions" / "obstacle_avoidance"
    assert find_submission(folder / "obstacle_avoidance_agent.py").account() == []


def test_several_packages_are_a_workspace(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / "src" / name).mkdir(parents=True)
        (tmp_path / "src" / name / "package.xml").write_text("<package/>")
        (tmp_path / "src" / name / "setup.py").write_text("")
    for given, folders in (("", ("src/one", "src/two")), ("src/one", ("",))):
        package = find_submission(tmp_path / given, "agent.py").package
        assert package is not None
        assert package.folders == folders
