"""Make the references' ghosts: their figures and tracks in the worlds of a race, and nothing else.

`python -m grader.authoring.ghosts` drives them and writes `grader/drive/ghosts.json`, which
students have, too; `tests/grader/drive/test_race.py` compares it with a drive.
"""

import json
import sys
from typing import Any

import msgspec

from grader.course.exercises import Exercise, all_exercises
from grader.course.submission import find_submission
from grader.drive.node import drive_node, scenario_for
from grader.drive.race import GHOSTS, lap_of, track_of
from grader.exercises import contract_of
from grader.launchers import fork_server
from rclpy_virtual_time import ForkServer


def ghosts_of(exercise: Exercise, forkserver: ForkServer) -> dict[str, Any]:
    """Return the reference's lap and track in each world of an exercise's race, by the world."""
    contract = contract_of(exercise)
    reference = find_submission(exercise.solutions / exercise.files[0], exercise.files[0])
    made = {}
    for world in contract.race:
        recording = drive_node(reference, scenario_for(world), forkserver)
        lap = lap_of(recording, contract)
        made[world] = {"lap": msgspec.to_builtins(lap), "track": track_of(recording)}
    return made


def main() -> int:
    """Write the file."""
    with fork_server() as forkserver:
        made = {each.slug: ghosts_of(each, forkserver) for each in all_exercises()}
    raced = {slug: worlds for slug, worlds in made.items() if worlds}
    GHOSTS.write_text(json.dumps(raced, separators=(",", ":")) + "\n", "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
