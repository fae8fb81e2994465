"""Real kernels, one for each file of tests."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("ipykernel", reason="ipykernel is not installed (the extra `notebooks`)")

from kernels import Kernel, started


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The notebook's folder."""
    return tmp_path_factory.mktemp("notebook")


@pytest.fixture(scope="module")
def kernel(folder: Path) -> Iterator[Kernel]:
    """A kernel in that folder, with the course's names."""
    argv = [sys.executable, "-m", "ipykernel_launcher"]
    with started(folder, argv, **os.environ) as running:
        said = running.run("%load_ext grader.notebook")
        assert (said.status, said.text.strip(), said.stderr) == ("ok", "", "")
        yield running
