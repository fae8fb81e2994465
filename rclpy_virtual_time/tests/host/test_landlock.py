"""Landlock: what a host may read and write, in processes of its own."""

import ctypes
import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest
from children import error_of, in_child

from rclpy_virtual_time.host.sandbox import kernel_filters as sandbox

libc = ctypes.CDLL(None, use_errno=True)

filters = pytest.mark.skipif(not sandbox.has_seccomp(), reason="this kernel has no seccomp filters")
landlock = pytest.mark.skipif(not sandbox.landlock_abi(), reason="this kernel has no Landlock")


def confined(
    body: Callable[[], object], read: tuple[Path, ...] = (), write: tuple[Path, ...] = ()
) -> str:
    """Run a function in a child behind Landlock."""

    def run() -> object:
        sandbox.restrict_files(read, write)
        return body()

    return in_child(run)


# --- files ---------------------------------------------------------------------------------------


@pytest.fixture
def places(tmp_path: Path) -> dict[str, Path]:
    """A folder to write in, one to read, one that is neither; a file in each."""
    found = {}
    for name in ("own", "library", "closed"):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "file").write_text(name)
        (folder / "program").write_text("#!/bin/sh\n")
        (folder / "program").chmod(0o755)
        found[name] = folder
    return found


def try_in(places: dict[str, Path], body: Callable[[], object]) -> str:
    return confined(lambda: error_of(body), (places["library"],), (places["own"],)).strip("'")


@landlock
def test_reading(places: dict[str, Path]) -> None:
    for name, wanted in (("own", "fine"), ("library", "fine"), ("closed", "EACCES")):
        folder = places[name]
        assert try_in(places, (folder / "file").read_text) == wanted
        assert try_in(places, lambda folder=folder: os.listdir(folder)) == wanted


@landlock
@pytest.mark.parametrize("name", ["library", "closed"])
def test_writing_outside(places: dict[str, Path], name: str) -> None:
    folder = places[name]
    ways: dict[str, Callable[[], object]] = {
        "write": lambda: (folder / "file").write_text("mine"),
        "append": lambda: os.open(folder / "file", os.O_WRONLY | os.O_APPEND),
        "create": (folder / "new").touch,
        "remove": (folder / "file").unlink,
        "make a folder": (folder / "new").mkdir,
        "make a link": lambda: (folder / "new").symlink_to("file"),
        "make a pipe": lambda: os.mkfifo(folder / "new"),
        "rename": lambda: (folder / "file").rename(folder / "new"),
        "move out": lambda: (folder / "file").rename(places["own"] / "new"),
        "move in": lambda: (places["own"] / "file").rename(folder / "new"),
        "link out": lambda: os.link(folder / "file", places["own"] / "new"),
    }
    for way, body in ways.items():  # a move is EXDEV where Landlock knows none
        assert try_in(places, body) in ("EACCES", "EXDEV"), way
    assert (folder / "file").read_text() == name


@pytest.mark.parametrize("abi", [1, 2, 3, 4, 5])
@landlock
def test_older_kernels_get_what_they_know(
    abi: int, places: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    if abi > sandbox.landlock_abi():
        pytest.skip("this kernel is older still")
    monkeypatch.setattr(sandbox, "landlock_abi", lambda: abi)
    assert try_in(places, (places["closed"] / "file").read_text) == "EACCES"
    assert try_in(places, lambda: (places["own"] / "file").write_text("x")) == "fine"
    if abi >= 3:
        for name, wanted in (("own", "fine"), ("library", "EACCES"), ("closed", "EACCES")):
            file = places[name] / "file"
            assert try_in(places, lambda file=file: os.truncate(file, 0)) == wanted


@landlock
def test_its_own_folder_is_its_own(places: dict[str, Path]) -> None:
    own = places["own"]

    def work() -> None:
        (own / "file").write_text("new")
        (own / "folder").mkdir()
        (own / "file").rename(own / "folder" / "file")
        (own / "link").symlink_to("folder/file")
        assert (own / "link").read_text() == "new"
        (own / "folder" / "file").unlink()

    assert try_in(places, work) in ("fine", "EXDEV")  # before ABI 2 no move between folders


@landlock
def test_running_programs(places: dict[str, Path]) -> None:
    """Also a program that may be read, or that the process has written."""
    for folder in (*places.values(), Path("/bin")):
        program = folder / ("true" if folder == Path("/bin") else "program")
        assert try_in(places, lambda program=program: os.execv(program, ["x"])) == "EACCES"


@landlock
def test_neither_links_nor_another_rule_lead_anywhere(places: dict[str, Path]) -> None:
    own, closed = places["own"], places["closed"]
    (own / "link").symlink_to(closed / "file")
    (own / "folder").symlink_to(closed)

    def loosen() -> str:
        sandbox.restrict_files([Path("/")], [Path("/")])
        return error_of((closed / "file").read_text)

    assert confined(loosen, write=(own,)) == "'EACCES'"
    assert try_in(places, (own / "link").read_text) == "EACCES"
    assert try_in(places, (own / "folder" / "file").read_text) == "EACCES"
    assert try_in(places, lambda: (own / "folder" / "new").write_text("x")) == "EACCES"
    assert try_in(places, Path(f"{own}/../closed/file").read_text) == "EACCES"
    assert try_in(places, Path(f"/proc/self/root{closed}/file").read_text) == "EACCES"


@landlock
def test_a_single_file_can_be_shown(places: dict[str, Path]) -> None:
    file = places["closed"] / "file"
    assert confined(file.read_text, read=(file, places["own"] / "not there")) == "'closed'"
    said = confined(lambda: error_of((places["closed"] / "program").read_text), read=(file,))
    assert said == "'EACCES'"


@landlock
@pytest.mark.skipif(sandbox.landlock_abi() < 4, reason="this kernel's Landlock knows no network")
def test_no_tcp() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = server.getsockname()
        said = confined(lambda: error_of(lambda: socket.socket().connect(address)))
    assert said == "'EACCES'"
    assert confined(lambda: error_of(lambda: socket.create_server(("127.0.0.1", 0)))) == "'EACCES'"


@landlock
@pytest.mark.skipif(sandbox.landlock_abi() < 6, reason="this kernel's Landlock has no scopes")
def test_no_signals_and_no_abstract_sockets() -> None:
    parent = os.getpid()
    assert confined(lambda: error_of(lambda: os.kill(parent, 0))) == "'EPERM'"
    with socket.socket(socket.AF_UNIX) as keeper:
        keeper.bind(f"\0course-test-{parent}")
        keeper.listen()

        def connect() -> None:
            socket.socket(socket.AF_UNIX).connect(f"\0course-test-{parent}")

        assert confined(lambda: error_of(connect)) == "'EPERM'"


def test_a_kernel_without_landlock_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sandbox, "landlock_abi", lambda: 0)
    with pytest.raises(OSError, match="no Landlock"):
        sandbox.restrict_files([], [])


# --- memory --------------------------------------------------------------------------------------


def test_a_process_can_hide_its_memory() -> None:
    def hidden() -> int:
        sandbox.hide_memory()
        return int(libc.prctl(3, 0, 0, 0, 0))  # PR_GET_DUMPABLE

    assert in_child(hidden) == "0"
