"""What there is to say about a grading: the words, and the order, of all that shows one."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from rclpy_virtual_time import readable

Check = Mapping[str, Any]

OUTCOMES = {  # outcome: sign, sign on an ASCII terminal, word, style
    "pass": ("✓", "+", "pass", "green"),
    "fail": ("✗", "x", "FAIL", "bold red"),
    "skip": ("\N{EN DASH}", "-", "skip", "dim"),
    "error": ("!", "!", "ERROR", "bold magenta"),
    "inconclusive": ("?", "?", "unsure", "yellow"),
    "unavailable": ("\N{EN DASH}", "-", "skip", "yellow"),  # a library is not installed
}
SKIPPED = ("skip", "unavailable")
UNJUDGED = ("error", "inconclusive", "unavailable")  # neither won nor lost
MAX_TEXT = 1200  # [characters] of one message; the page has all of it
MAX_WISH = 60  # [characters] of what was expected, before what came


def in_order(checks: Iterable[Check]) -> list[Check]:
    """Return checks in the order shown: failed checks by task, then the others by task.

    Those about all tasks come after the tasks, and those without points last.
    """
    return sorted(checks, key=_place)


def _place(check: Check) -> tuple[bool, int, float]:
    rank = {"fail": 0, "error": 1, "inconclusive": 1, "pass": 3}.get(check["outcome"], 2)
    return check.get("kind") == "field", rank, check.get("task") or math.inf


def first_failure(grading: Mapping[str, Any]) -> Check | None:
    """Return the check to begin with: the one that shows the cause, or the first failed check.

    One that could not be judged, if none failed; None if there is none either.
    """
    checks = in_order(grading.get("checks", []))
    wrong = [check for check in checks if check["outcome"] == "fail"]
    seen = (grading.get("cause") or {}).get("check")
    unsure = (check for check in checks if check["outcome"] in ("error", "inconclusive"))
    at_cause = (check for check in wrong if seen and check.get("id") == seen)
    return next(at_cause, wrong[0] if wrong else next(unsure, None))


def cause_of(grading: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the most probable cause of the failures, as lines (name, text); [] if unknown."""
    cause = grading.get("cause") or {}
    hint = cause.get("hint") or {}
    lines = [
        ("cause", cause.get("text", "")),
        ("line", cause.get("where", "")),
        ("hint", f"{hint.get('title', '')} ({hint.get('anchor', '')})" if hint else ""),
    ]
    return [(name, str(text)) for name, text in lines if text]


def group_fact(kind: str, group: Sequence[Check]) -> str:
    """Say how a group of checks, `core` or `field`, came out."""
    if kind != "core":
        return f"{passed(group)} of {len(group)} passed, no points"
    judged = (check for check in group if check["outcome"] not in UNJUDGED)
    most = sum(check["max_points"] for check in judged)
    return f"{spell_points(sum(check['points'] for check in group))} of {spell_points(most)} points"


def points_of(check: Check) -> str:
    """Return a check's points as text; "-" if the check was not judged."""
    if check.get("kind") == "field" or not check.get("max_points"):
        return ""
    if check["outcome"] in UNJUDGED:
        return "-"
    return f"{spell_points(check['points'])}/{spell_points(check['max_points'])}"


def seen_of(check: Check) -> str:
    """Say in one sentence what was expected, what came, and when; a long wish gives way."""
    time, scenario = check.get("time"), check.get("scenario")
    wish = str(check.get("expected") or "")
    wish = wish if len(wish) <= MAX_WISH else f"{wish[:MAX_WISH].rstrip()} …"
    parts = [
        f"expected {wish}" if wish else "",
        f"actual {check['actual']}" if check.get("actual") else "",
        f"at {time:.2f} s" + (f" in {scenario}" if scenario else "") if time is not None else "",
    ]
    return "; ".join(filter(None, parts))


def hint_of(check: Check) -> str:
    """Say where the check's hint stands in hints.md."""
    task, _, number = str(check.get("hint") or "").partition(".")
    return f"hint {number} of task {task} in hints.md" if number else ""


def facts_of(check: Check) -> list[tuple[str, str]]:
    """Return the facts (name, text) about a check that did not pass."""
    facts = [("expected", check.get("expected")), ("actual", check.get("actual"))]
    time, scenario = check.get("time"), check.get("scenario")
    if time is not None:
        facts.append(("when", f"{time:.2f} s" + (f" in {scenario}" if scenario else "")))
    elif scenario and check["outcome"] not in SKIPPED:
        facts.append(("run", str(scenario)))
    facts += [("code", check.get("where")), ("log", check.get("log"))]
    facts.append(("next", check.get("help")))
    return [(name, str(text)) for name, text in facts if text]


def with_details(checks: Iterable[Check]) -> Iterator[tuple[Check, bool]]:
    """Yield checks, each with whether to show details: a reason for skipping is shown once."""
    reason = ""  # of the last skipped check
    for check in checks:
        skipped = check["outcome"] in SKIPPED
        yield check, check["outcome"] != "pass" and not (skipped and check.get("message") == reason)
        reason = check.get("message", "") if skipped else ""


def share_of(grading: Mapping[str, Any]) -> float:
    """Return the share of the points that was won, 0 … 1."""
    score, most = grading.get("score") or 0, grading.get("max_score") or 0
    return float(min(1.0, max(0.0, score / most))) if most else 0.0


def score_of(grading: Mapping[str, Any]) -> str:
    """Return the score, with the points that could be won."""
    score, most = (grading.get(key) or 0 for key in ("score", "max_score"))
    return f"{spell_points(score)} / {spell_points(most)}"


def score_notes(grading: Mapping[str, Any]) -> list[str]:
    """Return notes for a reader of the score."""
    checks = grading.get("checks", [])
    absent = sum(float(c["max_points"]) for c in checks if c["outcome"] == "unavailable")
    said = f"{spell_points(absent)} more points are about libraries that are not installed here"
    capped = str(grading.get("cap") or "")
    return [*([capped] if capped else []), *([said] if absent else [])]


def points_by_question(grading: Mapping[str, Any]) -> str:
    """Return the points by what the checks ask: `wiring 5/5, decision 40/45`."""
    found: dict[str, list[float]] = {}
    for check in grading.get("checks", []):
        if check.get("asks") and check.get("kind") == "core" and check["outcome"] not in UNJUDGED:
            sums = found.setdefault(check["asks"], [0.0, 0.0])
            sums[0] += check["points"]
            sums[1] += check["max_points"]
    return ", ".join(f"{asks} {won:g}/{most:g}" for asks, (won, most) in found.items())


def field_words(grading: Mapping[str, Any]) -> tuple[str, str]:
    """Return the words on the field checks: the badge's, and the rest of the line."""
    field = [check for check in grading.get("checks", []) if check.get("kind") == "field"]
    if grading.get("field_ready"):
        return "field-ready", ": works on other sensors and networks too"
    if grading.get("field_ready") is None:
        return "", "field checks were not run"
    return "", f"not field-ready yet ({passed(field)} of {len(field)} field checks passed)"


def spell_points(points: float) -> str:
    """Return points without superfluous decimals."""
    return f"{points:g}"


def plain(text: Any) -> str:
    """Return student text without escape sequences and control characters, cut to MAX_TEXT."""
    clean = readable(str(text)).expandtabs(4)
    return clean if len(clean) <= MAX_TEXT else clean[: MAX_TEXT - 2].rstrip() + " …"


def passed(checks: Sequence[Check]) -> int:
    return sum(check["outcome"] == "pass" for check in checks)
