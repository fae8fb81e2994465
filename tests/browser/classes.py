"""A synthetic class: students of known ability in two exercises, some of them held or hostile."""

import random
from typing import Any

from grader.classroom.results.options import ResultOptions
from grader.classroom.row import GRADED, HELD, StoredResult
from grader.lms.names import student_id

HOSTILE = (
    "</style></script><script>window.pwned=1</script><img src=x onerror=window.pwned=1>"
    " \u202eevil \x1b[31mred \u05e9\u05dc\u05d5\u05dd &amp; {{7*7}}\nsecond line"
)
LONG = "a_very_long_name_" * 18  # 306 characters without a space
NAMES = (
    "ada", "ben", "chen", "dilara", "emre", "fatima", "giulia", "hugo", "ines", "jonas", "kofi",
    "lena", "mateo", "noor", "olga", "pavel", "quynh", "ravi", "sofia", "tomas", "ugo", "vera",
    "wei", "ximena", "yusuf", "zoe",
)  # fmt: skip

# (id, title, points, how hard: the ability at which half pass, what is said)
OBSTACLES = (
    ("wiring", "The node starts, spins, listens to /scan and publishes on /cmd_vel.", 5, -2.5,
     "there is no subscription on /scan"),
    ("one_command_per_scan", "Each scan is answered by exactly one Twist.", 5, -1.5,
     "2 commands for the scan at 1.10 s"),
    ("clear_zone", "From 1.0 m on the robot drives at 0.50 m/s.", 20, -1.0, "wrong speed"),
    ("slow_zone", "From 0.5 m to below 1.0 m the robot drives at 0.15 m/s.", 20, -0.4,
     "“0.71 m ahead”: wrong speed"),
    ("stop_zone", "Below 0.5 m the robot stands still.", 20, 0.0, "“0.42 m ahead”: wrong speed"),
    ("invalid_readings", "NaN and readings outside the limits are ignored.", 15, 1.1,
     "“NaN among good readings”: wrong speed"),
    ("blind", "Without any usable reading the robot stands still, and the node lives.", 15, 1.6,
     "the node died at 2.31 s: ValueError: min() arg is an empty sequence"),
)  # fmt: skip
GOALS = (
    ("wiring", "The node starts, spins and listens to /odom and /goal_pose.", 5, -2.2,
     "there is no publisher on /cmd_vel"),
    ("reaches_goal", "The robot reaches (5, 3) within 30 s.", 30, -0.6, "never arrived"),
    ("turns_short_way", "The robot turns the short way round.", 25, 0.3, "turned by 4.71 rad"),
    ("new_goal", "A new goal replaces the old one at once.", 25, 0.9, "went on to the old goal"),
    ("bad_input", "A goal that is not finite is ignored.", 15, 1.4, "commanded NaN"),
)  # fmt: skip
FIELD = (("field_lds01", "Works with an LDS-01: beams from 0 to 2π, 5 Hz."),)

VERSIONS = {"python": "3.11.2", "rclpy-agents-course": "0.1.0", "numpy": "2.1.0"}


def grading(slug: str, ability: float, chance: random.Random) -> dict[str, Any]:
    """One grading: a check is passed by those who are able enough, give or take."""
    table = OBSTACLES if slug == "obstacle_avoidance" else GOALS
    checks, broken = [], False
    for id_, title, points, hard, said in table:
        passes = not broken and ability + chance.gauss(0, 0.6) > hard
        outcome = "pass" if passes else "skip" if broken else "fail"
        failed = outcome == "fail"
        checks.append(
            {
                "id": id_, "title": title, "kind": "core", "outcome": outcome,
                "points": points if passes else 0, "max_points": points,
                "message": said if failed else "", "expected": "0.15 m/s" if failed else "",
                "actual": "0.50 m/s" if failed else "", "time": 2.1 if failed else None,
                "scenario": "avoid_zones" if failed else None, "help": "",
            }
        )  # fmt: skip
        broken = broken or (id_ == "wiring" and not passes)
    full = all(check["outcome"] == "pass" for check in checks)
    for id_, title in FIELD:
        checks.append({"id": id_, "title": title, "kind": "field", "points": 0, "max_points": 0,
                       "outcome": "pass" if full else "skip", "message": ""})  # fmt: skip
    score = sum(check["points"] for check in checks)
    return {
        "exercise": slug, "file": f"/srv/in/{slug}.py", "tier": 1, "score": score,
        "max_score": 100, "provisional": False, "field_ready": full, "notes": [],
        "checks": checks, "versions": VERSIONS,
        "recordings": [{"scenario": "avoid_zones", "title": "Zones", "seed": 4711, "duration": 9.0,
                        "outcome": "completed", "bag": "/srv/out/bag"}],
    }  # fmt: skip


def stored(student: str, slug: str, made: dict[str, Any] | None, **parts: Any) -> StoredResult:
    return StoredResult(
        **{
            "student": student, "exercise": slug, "file_names": (f"{slug}_agent.py",),
            "input_hash": "0" * 64, "state": GRADED, "grading": made, "recordings": None,
            "wall_s": 1.5, "attempts": 1, "problem": "",
            "finished": "2026-05-04T09:12:00Z", **parts,
        }
    )  # fmt: skip


def whole_class() -> tuple[list[StoredResult], ResultOptions]:
    """26 students and a few odd ones."""
    chance = random.Random(1)
    results = []
    for index, student in enumerate(map(student_id, (*NAMES, HOSTILE, LONG))):
        ability = chance.gauss(0.6, 1.1)
        for slug in ("obstacle_avoidance", "goal_seeking"):
            if slug == "goal_seeking" and index % 9 == 8:
                continue  # not handed in
            made = grading(slug, ability, chance)
            wall = round(1.4 + chance.expovariate(1.5), 2)
            results.append(stored(student, slug, made, wall_s=wall))
    results[3] = stored(
        "ben",
        "goal_seeking",
        None,
        state=HELD,
        attempts=3,
        wall_s=64.0,
        problem="the worker died three times while it graded this file",
    )
    stalled = grading("obstacle_avoidance", 3.0, chance)
    stalled["checks"][4] |= {
        "outcome": "inconclusive",
        "points": 0,
        "message": "the machine stood still for 2.4 s",
    }
    results[4] = stored("chen", "obstacle_avoidance", stalled, state=HELD, attempts=2)
    results[-1].grading["checks"][1] |= {
        "outcome": "fail",
        "points": 0,
        "message": HOSTILE,
        "title": HOSTILE,
    }
    notes = [
        "14 gradings were made again: the canary goal_seeking/mutant/turns_the_long_way passed a "
        "check at 09:31 that it must fail, since the machine stalled.",
        HOSTILE,
    ]
    title = "Robotics 2, summer"
    return results, ResultOptions(title=title, notes=notes)
