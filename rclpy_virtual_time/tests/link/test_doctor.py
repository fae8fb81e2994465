"""What isolates hosts on a machine, and what a submission can do where less does."""

import functools

import pytest

from rclpy_virtual_time.host.frames import Hello
from rclpy_virtual_time.host.sandbox.layers import CALLS, FILES, LAYERS, LIMITS, USER
from rclpy_virtual_time.link import doctor
from rclpy_virtual_time.link.doctor import Diagnosis, Layer, gaps


def test_this_machine_can_run_nodes() -> None:
    found = Diagnosis.of_this_machine()

    assert found.problem == ""
    assert found.ros
    assert tuple(layer.name for layer in found.layers) == LAYERS
    assert found.layers[0] == Layer(LIMITS, True)
    assert all(layer.text.startswith(("keeps out: ", "needs ")) for layer in found.layers)


@pytest.mark.parametrize(
    ("layers", "allowed"),
    [(LAYERS, True), ((LIMITS, FILES), True), ((LIMITS, USER, CALLS), False), ((LIMITS,), False)],
)
def test_foreign_code_needs_a_wall_around_files(layers: tuple[str, ...], allowed: bool) -> None:
    here = tuple(Layer(name, name in layers) for name in LAYERS)
    found = Diagnosis(python="3.12", ros="wheels", problem="", layers=here)
    assert (found.foreign_code == "") == allowed


WORDS = {  # taken away: what is said of it
    "": (),
    "mounts": ("the disk of", "fill /dev/shm"),
    "files": ("read solutions",),
    "calls": ("start programs and processes",),
    "user": ("run as root",),
    "network": ("datagrams",),
    "calls network": ("talk to the network",),
}


@pytest.mark.parametrize("off", WORDS)
def test_what_is_open_is_said_in_plain_words(off: str) -> None:
    there = tuple(layer for layer in LAYERS if layer not in off.split())
    said = " ".join(gaps(Hello(there, landlock=6, counted=True), root=True))

    assert all(words in said for words in WORDS[off])
    assert bool(said) == bool(off)


@pytest.mark.parametrize(
    ("abi", "filtered", "said"), [(2, False, True), (2, True, False), (3, False, False)]
)
def test_an_old_landlock_and_uncounted_threads_are_said(
    abi: int, filtered: bool, said: bool
) -> None:
    there = [layer for layer in LAYERS if filtered or layer != CALLS]
    text = " ".join(gaps(Hello(tuple(there), landlock=abi), root=True))

    assert (f"Landlock {abi} lets files be emptied" in text) == said
    assert "does not count a submission's threads" in text


def test_a_fork_server_with_less_is_diagnosed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not only made-up means: hosts that really lack layers say so."""
    less = functools.partial(doctor.ForkServer, layers=(LIMITS, FILES), landlock=1)
    monkeypatch.setattr(doctor, "ForkServer", less)
    found = Diagnosis.of_this_machine()

    here = {layer.name: layer for layer in found.layers if layer.here}
    if FILES not in here:
        pytest.skip("no Landlock on this machine")
    assert set(here) == {LIMITS, FILES}
    assert here[FILES].text.endswith("(Landlock ABI 1)")
    assert any("Landlock 1 lets files be emptied" in gap for gap in found.gaps)
