"""Fork servers that stay warm: one for the same libraries, no more than wanted, none at the end."""

import os
from pathlib import Path

import pytest

from grader.launchers import launcher_pool


def children() -> set[str]:
    """Return the processes that this thread has started and not waited for."""
    return set(Path(f"/proc/self/task/{os.getpid()}/children").read_text().split())


def test_the_same_libraries_are_imported_once() -> None:
    before = children()
    with launcher_pool() as warm:
        plain, other = warm.of(), warm.of(("json",))

        assert warm.of() is plain
        assert warm.of(("json",)) is other is not plain
        assert len(children() - before) == 2
        warm.close()  # after a fault nobody knows in what state one is
        assert children() <= before
        assert warm.of() is not plain
    assert children() <= before


def test_the_one_that_has_waited_longest_goes_first() -> None:
    before = children()
    with launcher_pool(most=2) as warm:
        plain, _ = warm.of(), warm.of(("json",))
        warm.of()
        warm.of(("csv",))  # in place of json's

        assert len(children() - before) == 2
        assert warm.of() is plain


@pytest.mark.parametrize("times", [1, 2])
def test_closing_needs_nothing_to_be_open(times: int) -> None:
    warm = launcher_pool()
    for _ in range(times):
        warm.close()
