"""A moment of a page's run, which is made again for it; and what `course drive --at` says of it."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import Any

from test_drives import said_by_page

from grader import drive
from grader.course.exercises import find_exercise
from grader.course.submission import find_submission
from grader.launchers import ForkServerPool
from rclpy_virtual_time.host.frames import Moment

AT = [1.234, 4.0]
# The last one's launch file is read first, and what was read of it is kept
DRIVEN = {"slow_alone": "slow_model", "live_wall": "live_parameters", "demo_wall": "three_nodes"}


def test_a_page_looks_into_the_run_that_it_has_made(
    forkservers: ForkServerPool, tmp_path: Path
) -> None:
    looker = forkservers.of((Moment.LIBRARY,))
    nodes = [
        find_exercise(slug).solutions / find_exercise(slug).files[0] for slug in DRIVEN.values()
    ]
    orders: list[dict[str, Any]] = [
        {"file": str(node), "scenario": name, "others": find_exercise(slug).files, "tell": True}
        for node, (name, slug) in zip(nodes, DRIVEN.items(), strict=True)
    ]
    said_by_page(tmp_path / "before", orders)
    said = said_by_page(tmp_path / "looked", [{**order, "look": AT} for order in orders])
    for node, order, told in zip(nodes, orders, said, strict=True):
        submission = find_submission(node, node.name, order["others"][1:])
        scenario = drive.scenario_for(order["scenario"])
        there = drive.drive_node(drive.unpacked(submission, looker), scenario, looker, look=AT)
        kept = (tmp_path / when / f"{scenario.name}.pickle" for when in ("before", "looked"))
        here = [pickle.loads(file.read_bytes())[0].digest() for file in kept]
        assert here == [there.digest()] * 2
        assert told["tables"] == json.loads(json.dumps(drive.tables_of(there, AT)))
        assert len(told["tables"]) == (3 if scenario.name == "demo_wall" else 1)
        assert "printed" not in told
