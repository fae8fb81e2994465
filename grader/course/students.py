"""Every student gets different worlds, which only the instructor can reproduce."""

from __future__ import annotations

import hashlib
import hmac
from pathlib import Path

from grader.errors import InputError

MIN_SECRET = 16  # [bytes]
MAKE = "openssl rand -hex 32 > course.secret"
SECRET_SEEDS = 2**63  # seeds from here on belong to a student, and are shown to nobody

Seed = int | str  # what a grading is varied by: a number of `--seed`, or a student's key


def student_key(secret: bytes, student: str, exercise: str) -> str:
    """Return a student's key in an exercise: the HMAC-SHA256 of both under the course's secret.

    Without the secret nobody can compute it, or search for a name whose worlds would be easy.
    """
    # lengths in front: ("ab", "c") and ("a", "bc") are different students
    parts = [part.encode() for part in (student, exercise)]
    message = b"".join(len(part).to_bytes(4, "big") + part for part in parts)
    return hmac.new(secret, message, hashlib.sha256).hexdigest()


def secret_seed(key: str, scenario: str, candidate: int = 0) -> int:
    """Return the seed of a student's trial, 63 bits of an HMAC; no trial's tells another's."""
    message = f"{scenario}/{candidate}".encode()
    digest = hmac.new(bytes.fromhex(key), message, hashlib.sha256).digest()
    return int.from_bytes(digest[:8], "big") | SECRET_SEEDS


def public_seed(seed: int) -> int | None:
    """Return a trial's seed if it may be shown; None if it is a student's."""
    return seed if seed < SECRET_SEEDS else None


def host_seed(seed: int) -> int:
    """Return a hash of a trial's seed, for `random` in the node's process."""
    digest = hashlib.sha256(f"host {seed}".encode()).digest()
    return int.from_bytes(digest[:7], "big")


def read_secret(path: Path) -> bytes:
    """Return the course's secret from its file.

    Raises InputError: the file can't be read, or is too short for a secret.
    """
    try:
        secret = path.read_bytes().strip()
    except OSError as error:
        raise InputError(
            f"{path}: cannot read the course's secret ({error.strerror}); `{MAKE}` makes one"
        ) from None
    if len(secret) < MIN_SECRET:
        raise InputError(
            f"{path}: a secret of {len(secret)} bytes, expected at least {MIN_SECRET}; "
            f"make one with `{MAKE}`"
        )
    return secret
