"""A folder of scenarios of one's own, in place of the course's."""

from pathlib import Path

import pytest

from sim import scenario_files


@pytest.fixture
def course(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder, `walls`, in which scenarios are found by name."""
    monkeypatch.setattr(scenario_files, "SCENARIOS", ((tmp_path, "*/*.toml"),))
    folder = tmp_path / "walls"
    folder.mkdir()
    return folder
