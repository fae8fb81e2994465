"""Make random what is random in the same way in every run of the same trial."""

from __future__ import annotations

import os
import random
import sys
from typing import Any


def seed(value: int) -> None:
    """Seed `random`, numpy's generators, `uuid4`, `secrets` and what else asks for entropy.

    What is created without a seed asks `os.urandom` for one, which gets a seeded source.
    """
    source = random.Random(value)
    stdlib_random: Any = random
    os.urandom = stdlib_random._urandom = source.randbytes
    if hasattr(os, "getrandom"):
        os.getrandom = lambda size, flags=0: source.randbytes(size)
    plain_seed = random.Random.seed

    def seeded(self: Any, a: Any = None, version: int = 2) -> None:
        if a is None:  # Python would ask the kernel of the machine
            a = int.from_bytes(os.urandom(32), "little")
        plain_seed(self, a, version)

    stdlib_random.Random.seed = seeded
    random.seed(value)
    if numpy := sys.modules.get("numpy"):
        numpy.random.seed(value % 2**32)
