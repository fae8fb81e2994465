"""Real kernels, one for each file of tests."""

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("ipykernel", reason="ipykernel is not installed (the extra `notebooks`)")

from kernels import Kernel, started


@pytest.fixture(scope="session", autouse=True)
def no_grammars(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Spare processes, too, the grammars that tests/conftest.py says of."""
    folder = tmp_path_factory.mktemp("none")
    (folder / "rfc3987_syntax.py").write_text("raise ImportError")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)
        yield


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
