"""Every student gets different worlds, which only the instructor can reproduce."""

from __future__ import annotations

import hashlib
import hmac
from pathlib import Path

from grader.errors import InputError

MIN_SECRET = 16  # [bytes]
SEEDS = 10**6


def student_seed(secret: bytes, student: str, exercise: str) -> int:
    """Return a student's seed in an exercise: the HMAC-SHA256 of both under the course's secret.

    Without the secret nobody can compute it, or search for a name whose worlds would be easy.
    """
    # lengths in front: ("ab", "c") and ("a", "bc") are different students
    parts = [part.encode() for part in (student, exercise)]
    message = b"".join(len(part).to_bytes(4, "big") + part for part in parts)
    digest = hmac.new(secret, message, hashlib.sha256).digest()
    return int.from_bytes(digest[:8], "big") % SEEDS


def read_secret(path: Path) -> bytes:
    """Return the course's secret from its file.

    Raises
    ------
    InputError
        The file can't be read, or is too short for a secret.
    """
    try:
        secret = path.read_bytes().strip()
    except OSError as error:
        raise InputError(f"{path}: cannot read the course's secret ({error.strerror})") from None
    if len(secret) < MIN_SECRET:
        raise InputError(
            f"{path}: a secret of {len(secret)} bytes, expected at least {MIN_SECRET}; "
            "make one with `openssl rand -hex 32`"
        )
    return secret
