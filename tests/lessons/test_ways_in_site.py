"""A site has others' ways only where it is built with them, and none of what is left out."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import pytest
from workspace_block import copy_files


@pytest.mark.parametrize(("asked", "there"), [(True, ["a"]), (False, [])])
def test_ways_are_copied_if_asked(tmp_path: Path, asked: bool, there: list[str]) -> None:
    made, ways, out = (tmp_path / name for name in ("made", "ways", "out"))
    for folder in (made, ways, out):
        folder.mkdir()
    (made / "offline.js").touch()
    (made / "plan.json").write_text(json.dumps({"exercises": {"a": {}, "b": {}, "c": {}}}))
    for slug in ("a", "b"):
        (ways / f"{slug}.json").write_text("[]")
    config = SimpleNamespace(
        course_workspace_made=True, course_workspace=str(made), course_left_out="b",
        course_ways=str(ways) if asked else "",
    )  # fmt: skip
    for _ in range(2):  # a folder of before is no reason
        copy_files(SimpleNamespace(config=config, outdir=str(out)), None)
    found = sorted(path.stem for path in (out / "_static" / "ways").glob("*"))
    plans = json.loads((out / "_static" / "workspace" / "plan.json").read_text())["exercises"]
    assert found == there
    assert {slug: about["ways"] for slug, about in plans.items()} == {"a": asked, "c": False}
