"""What an earlier run into the same folder was told: a later one needs to be told only changes.

Without this, a run that leaves out the roster would empty the gradebooks of their ids, and one
that leaves out the secret or the field checks would throw all gradings away.
"""

from __future__ import annotations

import hashlib
import hmac
import json
from dataclasses import replace
from typing import Any

from grader.classroom.options import Options
from grader.classroom.results.kept import OPTIONS, kept_options
from grader.classroom.store import Store
from grader.errors import InputError

SETTINGS = "settings"  # what the store calls those that results do not depend on


def as_before(options: Options, store: Store) -> tuple[Options, str]:
    """Return the options with what they leave out as it was, and a line that says what that is.

    Raises
    ------
    InputError
        The class has a secret, and this is none or another.
    """
    settings = _settings(store)
    if settings.get("secret", "") not in ("", _fingerprint(options.secret)):
        now = "another" if options.secret else "none"
        raise InputError(
            "--secret: expected the file that this class was graded with, in whose worlds all its "
            f"results are, but there is {now}; for other worlds give another --out"
        )
    told: list[str] = []
    if options.field is None:
        options = replace(options, field=bool(settings.get("field")))
        told += ["--field"] if options.field else []
    if not store.kept(OPTIONS):
        return options, ""
    try:
        kept = kept_options(store.kept(OPTIONS), {})
    except InputError:  # an earlier version of the course kept others
        return options, ""
    if not options.roster.sheets and kept.roster.sheets:
        options = replace(options, roster=kept.roster)
        told.append("--roster " + " ".join(sheet.file.name for sheet in kept.roster.sheets))
    if not options.columns and kept.columns:
        columns = tuple(f"{slug}={title}" for slug, title in kept.columns.items())
        options = replace(options, columns=columns)
        told.append("--column")
    if not options.hide and kept.hide != "nothing":
        options = replace(options, hide=kept.hide)
        told.append(f"--hide {kept.hide}")
    if options.nbgrader is None and kept.nbgrader is not None:
        options = replace(options, nbgrader=kept.nbgrader)
        told.append("--nbgrader")
    return options, f"as before: {', '.join(told)}" if told else ""


def keep_settings(options: Options, store: Store) -> None:
    """Keep what a later run has to be told again, or is not told."""
    kept = {"secret": _fingerprint(options.secret), "field": bool(options.field)}
    store.keep(SETTINGS, json.dumps(kept))


def _settings(store: Store) -> dict[str, Any]:
    text = store.kept(SETTINGS)
    found: dict[str, Any] = json.loads(text) if text else {}
    return found


def _fingerprint(secret: bytes | None) -> str:
    """Return what tells one secret from another and nothing else of it."""
    return hmac.new(secret, b"this class", hashlib.sha256).hexdigest()[:16] if secret else ""
