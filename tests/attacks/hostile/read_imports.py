"""Import the reference, the checks and the simulation, as if they lay on the path.

gains: nothing
score: 20
outcome: completed
"""

import importlib
import sys

from kit import TARGETS, attempt, drive, gained

sys.path[:0] = [TARGETS.get("repository", "/"), *TARGETS.get("folders", ())]
for name in ("grader.exercises.obstacle_avoidance.contract", "sim.scenario", "reference_solution"):
    with attempt():
        sys.modules.pop("grader", None)
        gained(f"imports what is not its own: {importlib.import_module(name).__name__}")
drive()
