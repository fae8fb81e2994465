"""Keep Python's garbage collector from delaying the robot.

The schedule of an hour is some hundred thousand objects. A full collection visits each of them and
stops the process for 0.1 s, a scan or more; so all that exists before the robot starts is exempt.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def settling() -> Iterator[None]:
    """Make a robot in this block: collect once at its end, and never visit its objects again."""
    gc.unfreeze()  # so that what an earlier robot left is collected
    gc.disable()
    try:
        yield
    finally:
        gc.collect()
        gc.freeze()
        gc.enable()
