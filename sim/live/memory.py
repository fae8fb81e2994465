"""Keep Python's garbage collection out of the robot's time.

The plan of an hour is some hundred thousand objects. A full collection looks at each of them and
stops the process for 0.1 s, which is two scans; so what there is before the robot starts is exempt.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def settling() -> Iterator[None]:
    """Let a robot be made in this block: one collection at its end, and none of it later."""
    gc.unfreeze()  # an earlier robot's remains are found
    gc.disable()
    try:
        yield
    finally:
        gc.collect()
        gc.freeze()
        gc.enable()
