"""Show a grading as a self-contained HTML page with replays, or as JSON. Knows no checks."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from grader.report.facts import in_order
from grader.report.graph import graph_html
from grader.report.replay import Ghosts, moments_of, replay_payload
from rclpy_virtual_time import readable

if TYPE_CHECKING:
    from grader.recording import Recording

__all__ = ["embedded_payload", "json_text", "page_html", "page_payload", "replay_payload"]

JsonDict = dict[str, Any]

PLAYER = Path(__file__).parent / "player"
STYLES = ("tokens.css", "page.css", "player.css")
# Concatenated in this order; a file uses only what stands before it.
SCRIPTS = (
    "dom.js",
    "replay.js",
    "playback.js",
    "camera.js",
    "draw.js",
    "world.js",
    "plot.js",
    "timeline.js",
    "account.js",
    "log.js",
    "layout.js",
    "opening.js",
    "player.js",
    "ask.js",
    "page.js",
)

GENERATED_BY = "rclpy agents course"


def page_payload(
    grading: Mapping[str, Any] | None,
    recordings: Sequence[Recording],
    title: str,
    opens_at: float | None = None,
    ghosts: Mapping[str, Ghosts] | None = None,
) -> JsonDict:
    """Return the payload of `page_html`: a grading (None for `course drive`) and its recordings.

    Without a grading the page opens at `opens_at` [s] of the first recording, if that is given.
    `ghosts` drive along in a scenario's replay.
    """
    checks = in_order(grading["checks"]) if grading else []
    beside = (ghosts or {}).get
    failed = {check["scenario"] for check in checks if check["outcome"] == "fail"}
    return {
        "grading": {**grading, "checks": checks} if grading else None,
        "replays": [
            replay_payload(
                recording, moments_of(checks, recording.name), beside(recording.name, ())
            )
            for recording in recordings
        ],
        # a run may leave out what an end would hear: it is no fault where all checks of it passed
        "graphs": [graph_html(r, judge=not checks or r.name in failed) for r in recordings],
        "title": title,
        "opens_at": opens_at,
        "generated_by": GENERATED_BY,
    }


def embedded_payload(
    checks: Sequence[Mapping[str, Any]],
    recordings: Sequence[Recording],
    title: str,
    ghosts: Mapping[str, Ghosts] | None = None,
) -> JsonDict:
    """Return only the replays, for a frame; it opens at what failed, or else at a drive."""
    page = page_payload({"checks": checks}, recordings, title, ghosts=ghosts)
    judged = [{key: each.get(key) for key in ("id", "outcome", "scenario")} for each in checks]
    return {**page, "grading": None, "embedded": True, "judged": judged}


def page_html(payload: Mapping[str, Any]) -> str:
    """Return one HTML file that needs no network; hostile text in the payload stays text.

    Its `graphs` are HTML already (see `graph_html`).
    The file is pure ASCII outside our own template, so it survives any transport.
    """
    style = "\n".join(_asset(name) for name in STYLES)
    sources = "\n".join(_asset(name) for name in SCRIPTS)
    script = f"(() => {{\n'use strict';\n{sources}\n}})();\n"
    title = readable(_valid_text(str(payload.get("title") or "Report")))
    parts = {
        "CSP": _content_security_policy(script, style),
        "TITLE": _ascii(html.escape(title)),
        "STYLE": style,
        "GRAPHS": _ascii("".join(f"<div>{graph}</div>" for graph in payload.get("graphs", ()))),
        "PAYLOAD": _inline_json({key: payload[key] for key in payload if key != "graphs"}),
        "SCRIPT": script,
    }
    pieces = _asset("page.html").split("@@")  # text, NAME, text, NAME, … text
    return "".join(parts[piece] if i % 2 else piece for i, piece in enumerate(pieces))


def json_text(grading: Mapping[str, Any]) -> str:
    """Return the grading as JSON with sorted keys, and null for NaN and infinity."""
    return json.dumps(_plain(grading), indent=2, sort_keys=True, allow_nan=False) + "\n"


def _ascii(text: str) -> str:
    return text.encode("ascii", "xmlcharrefreplace").decode("ascii")


def _asset(name: str) -> str:
    # Line endings must be \n: browsers normalise them before they hash a script.
    return (PLAYER / name).read_text(encoding="utf-8").replace("\r\n", "\n")


def _content_security_policy(script: str, style: str) -> str:
    """Return a policy that allows only our inline script and style, by hash, and no requests."""
    return "; ".join(
        (
            "default-src 'none'",
            f"script-src '{_hash(script)}'",
            f"style-src '{_hash(style)}'",
            "img-src data:",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )


def _hash(text: str) -> str:
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return "sha256-" + base64.b64encode(digest).decode("ascii")


def _inline_json(payload: Mapping[str, Any]) -> str:
    """Return JSON that can't close its <script> element: pure ASCII without <, > and &."""
    text = json.dumps(
        _readable(_plain(payload)), ensure_ascii=True, allow_nan=False, separators=(",", ":")
    )
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def _plain(value: Any) -> Any:
    """Return a value of JSON's types: numpy becomes Python, NaN and infinity become None."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, str | bool | int):
        return value
    return str(value)


def _readable(value: Any) -> Any:
    """Return a value whose texts have no control, bidi or escape characters."""
    if isinstance(value, str):
        return readable(value)
    if isinstance(value, dict):
        return {key: _readable(item) for key, item in value.items()}
    return [_readable(item) for item in value] if isinstance(value, list) else value


def _valid_text(text: str) -> str:
    """Return text without lone surrogates (of undecodable file names), which UTF-8 can't hold."""
    return text.encode("utf-8", "replace").decode("utf-8")
