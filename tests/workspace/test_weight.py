"""What a first visit to the page may fetch."""

from pathlib import Path

import pytest

from grader.errors import GraderError
from workspace.build import MOST, check_weight


def test_a_workspace_that_weighs_too_much_is_refused(tmp_path: Path) -> None:
    for name, size in (("page.js", 1000), ("pyodide/python.pack", MOST - 1000)):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        with (tmp_path / name).open("wb") as file:
            file.truncate(size)
    assert check_weight(tmp_path) == MOST
    (tmp_path / "more").write_bytes(b"1")
    with pytest.raises(GraderError, match=r"12,000,000 bytes .* got 12,000,001; leave out"):
        check_weight(tmp_path)
