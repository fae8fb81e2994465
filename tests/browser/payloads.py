"""Synthetic page payloads: a robot that touches a wall, one that reaches a goal, odd data."""

import base64
import math
from typing import Any

import numpy as np

from grader.recording import COMPLETED, Endpoint, Outcome, Recording
from grader.report.graph import graph_html
from sim.scenario_files import load_scenario

JsonDict = dict[str, Any]

ROOM = [[-1.0, -2.0], [5.0, -2.0], [5.0, 2.0], [-1.0, 2.0], [-1.0, -2.0]]
BOX = [[1.5, 0.9], [2.3, 0.9], [2.3, 1.5], [1.5, 1.5]]
WALL_X = 5.0  # [m]
RADIUS = 0.17  # [m]
SPEED = 0.5  # [m/s]
TOUCH = (WALL_X - RADIUS) / SPEED  # [s] when the robot arrives at the wall

HOSTILE = (
    "</script><script>window.pwned=1</script><img src=x onerror=window.pwned=1>"
    "<!-- \u2028\u2029 &lt; \u202eevil \U0001f916 \u05e9\u05dc\u05d5\u05dd"
    " \x1b[31m ]]> {{7*7}} @@CSP@@"
)


def room_scan(x: float, y: float, yaw: float) -> list[int]:
    """360 beams [mm] in the room; the box is left out."""
    scan = []
    for i in range(360):
        angle = -math.pi + i * math.tau / 360 + yaw
        c, s = math.cos(angle), math.sin(angle)
        along_x = ((5.0 if c > 0 else -1.0) - x) / c if abs(c) > 1e-9 else math.inf
        along_y = ((2.0 if s > 0 else -2.0) - y) / s if abs(s) > 1e-9 else math.inf
        scan.append(round(1000 * min(along_x, along_y)))
    for i in range(20, 40):
        scan[i] = 65535
    scan[100], scan[101] = 65533, 65534
    return scan


def scans_of(t: list[float], x: list[float], y: list[float], yaw: list[float]) -> JsonDict:
    rows = np.array([room_scan(*pose) for pose in zip(x, y, yaw, strict=True)], dtype="<u2")
    return {
        "t": t,
        "angle_min": -math.pi,
        "angle_increment": math.tau / 360,
        "range_max": 12.0,
        "beams": 360,
        "mm": base64.b64encode(rows.tobytes()).decode(),
    }


TEXTS = dict.fromkeys(("message", "expected", "actual", "help"), "")


def moment(t: float, check: str, title: str, **texts: str) -> JsonDict:
    return {"t": t, "check": check, "title": title, "outcome": "fail"} | TEXTS | texts


def replay(**parts: Any) -> JsonDict:
    return {
        "scenario": "empty",
        "title": "An empty run",
        "description": "",
        "seed": 1,
        "duration": 0.0,
        "robot": {"radius": RADIUS},
        "world": {"walls": [], "solids": []},
        "bench": False,
        "carts": [],
        "truth": {key: [] for key in ("t", "x", "y", "yaw", "v", "w", "clearance", "contact")},
        "commands": {"t": [], "v": [], "w": []},
        "scans": None,
        "goals": [],
        "log": [],
        "outcome": {"kind": "completed", "text": "", "at": 0.0},
        "moments": [],
        **parts,
    }


def wall_run(duration: float = 14.0) -> JsonDict:
    """The robot drives straight to the wall, touches it at TOUCH and stays there."""
    t = [round(0.05 * i, 3) for i in range(round(duration / 0.05) + 1)]
    x = [min(SPEED * s, WALL_X - RADIUS) for s in t]
    scan_t = [s for s in t if round(s * 20) % 2 == 0]
    scan_x = [min(SPEED * s, WALL_X - RADIUS) for s in scan_t]
    zeros = [0.0] * len(scan_t)
    driven = [SPEED if s < TOUCH else 0.0 for s in t]
    return replay(
        scenario="wall_ahead",
        title="Wall ahead",
        description="A wall stands across the way, a box beside it, and a cart crosses.",
        duration=duration,
        world={"walls": [ROOM, [[3.0, -2.0], [3.0, -1.2]]], "solids": [BOX]},
        carts=[
            {
                "polygon": [[-0.3, -0.2], [0.3, -0.2], [0.3, 0.2], [-0.3, 0.2]],
                "t": t,
                "x": [3.4 for _ in t],
                "y": [1.4 - 0.15 * s for s in t],
                "yaw": [-math.pi / 2 for _ in t],
            }
        ],
        truth={
            "t": t,
            "x": x,
            "y": [0.0] * len(t),
            "yaw": [0.0] * len(t),
            "v": [v * min(1.0, 0.2 + s) for v, s in zip(driven, t, strict=True)],
            "w": [0.2 * math.sin(s) for s in t],
            "clearance": [max(0.0, WALL_X - RADIUS - place) for place in x],
            "contact": [int(s >= TOUCH) for s in t],
        },
        commands={"t": scan_t, "v": [0.5 if s < 9 else 0.15 for s in scan_t], "w": zeros},
        scans=scans_of(scan_t, scan_x, zeros, zeros),
        log=[
            {
                "t": s,
                "level": "warn" if s > 9 else "info",
                "text": f"distance {WALL_X - place:.2f} m, velocity 0.50 m/s",
            }
            for s, place in zip(scan_t, scan_x, strict=True)
        ],
        outcome={"kind": "completed", "text": "", "at": duration},
        moments=[
            moment(
                8.66,
                "stop_zone",
                "Closer than 0.5 m the robot stands still.",
                expected="linear.x = 0.00 m/s for a scan with 0.49 m ahead",
                actual="linear.x = 0.50 m/s",
                message="The scan at 8.66 s had 0.49 m ahead, but the command was to drive on.",
                help="Which distance does your decision compare, and is the boundary < or <=?",
            ),
            moment(
                round(TOUCH, 3),
                "no_contact",
                "In closed loop the robot never touches anything.",
                expected="no contact, at least 0.20 m clearance",
                actual="contact with a wall",
            ),
        ],
    )


def goal_run(duration: float = 12.0) -> JsonDict:
    """The robot drives a curve to (3, 2) in an empty world, without a lidar."""
    t = [round(0.05 * i, 3) for i in range(round(duration / 0.05) + 1)]
    phase = [min(1.0, s / 11.0) * math.pi / 2 for s in t]
    x = [3.0 * math.sin(p) for p in phase]
    y = [2.0 * (1 - math.cos(p)) for p in phase]
    return replay(
        scenario="goal_beside",
        title="Goal beside the robot",
        duration=duration,
        truth={
            "t": t,
            "x": x,
            "y": y,
            "yaw": [math.atan2(2 * math.sin(p), 3 * math.cos(p)) for p in phase],
            "v": [0.3 * min(1.0, 0.05 + (1 - p / 1.6)) if p < 1.57 else 0.0 for p in phase],
            "w": [0.12 if p < 1.57 else 0.0 for p in phase],
            "clearance": [10.0] * len(t),
            "contact": [0] * len(t),
        },
        commands={
            "t": [0.1 * i for i in range(5, 110)],
            "v": [0.3] * 104 + [0.0],
            "w": [0.12] * 104 + [0.0],
        },
        goals=[{"t": 0.4, "x": 3.0, "y": 2.0}, {"t": 6.0, "x": None, "y": 1.0}],
        log=[{"t": 10.9, "level": "info", "text": "Goal reached!"}],
        outcome={"kind": "completed", "text": "", "at": duration},
    )


def odd_run() -> JsonDict:
    """Positions that are null, arrays of unequal length, hostile names, a long message."""
    return replay(
        scenario=HOSTILE,
        title=HOSTILE,
        description=HOSTILE * 3,
        duration=2.0,
        truth={
            "t": [0.0, 0.5, 1.0, None, 2.0],
            "x": [None, None, 0.4],
            "y": [None] * 5,
            "yaw": [0.0],
            "v": [None] * 5,
            "w": [],
            "clearance": [None],
            "contact": [0, 1, None],
        },
        commands={"t": [0.0, 1.0], "v": [None, 0.2], "w": [None]},
        scans={"t": [0.0, 1.0], "angle_min": None, "angle_increment": None, "range_max": None}
        | {"beams": 4, "mm": "not base64!"},
        goals=[{"t": None, "x": 1, "y": 1}, {"t": 1.0, "x": None, "y": None}],
        log=[
            {"t": None, "level": HOSTILE, "text": HOSTILE},
            {"t": 1.0, "level": "error", "text": ""},
        ],
        outcome={"kind": "exception", "text": HOSTILE, "at": None},
        moments=[
            moment(
                1.0, "hostile", HOSTILE, message="x" * 10_000, expected=HOSTILE, actual="y" * 3000
            )
        ],
    )


def check(check_id: str, title: str, outcome: str = "pass", **parts: Any) -> JsonDict:
    most = parts.pop("max_points", 10)
    points = most if outcome == "pass" else 0
    return TEXTS | {
        "id": check_id, "title": title, "kind": "core", "points": points, "max_points": most,
        "outcome": outcome, "time": None, "scenario": None, **parts,
    }  # fmt: skip


def grading(checks: list[JsonDict], *, field_ready: bool | None = None) -> JsonDict:
    core = [c for c in checks if c["kind"] == "core"]
    return {
        "exercise": "obstacle_avoidance",
        "file": "obstacle_avoidance_agent.py",
        "tier": 1,
        "score": sum(c["points"] for c in core),
        "max_score": sum(c["max_points"] for c in core),
        "field_ready": field_ready,
        "checks": checks,
        "recordings": [],
        "versions": {"course": "0.1.0", "rclpy": "7.1.5", "python": "3.11.7"},
    }


CHECKS = (  # id, outcome, points, title, what is said
    ("wiring", "pass", 10, "The node subscribes /scan and publishes Twist on /cmd_vel.", ""),
    ("clear_zone", "pass", 25, "From 1.0 m on the robot drives at 0.50 m/s.", ""),
    ("slow_zone", "pass", 25, "Between 0.5 m and 1.0 m the robot drives at 0.15 m/s.", ""),
    ("stop_zone", "fail", 10, "", ""),  # as in the moments of `wall_run`
    ("no_contact", "fail", 10, "", ""),
    ("invalid_readings", "inconclusive", 10, "NaN is ignored.", "The machine stalled twice."),
    ("drives_on", "skip", 5, "Once the way is free the robot drives on.", "It touched something."),
    ("callback_time", "error", 5, "No callback takes longer.", "The grader itself failed here."),
    ("pt2", "unavailable", 8, "Drives as a .pt2 predicts.", "PyTorch is not installed here"),
    ("field_lds01", "pass", 0, "Works with an LDS-01 lidar.", ""),
    ("field_best_effort", "fail", 0, "Works with a best-effort lidar.", "No scan arrived."),
)


def failing_checks() -> list[JsonDict]:
    made = [
        check(name, title, outcome, max_points=points, message=message)
        | {"kind": "core" if points else "field"}
        for name, outcome, points, title, message in CHECKS
    ]
    known = {moment["check"]: moment for moment in wall_run()["moments"]}
    for one in made:
        if (seen := known.get(one["id"])) is not None:
            one |= {key: seen[key] for key in ("title", *TEXTS)}
            one |= {"time": seen["t"], "scenario": "wall_ahead"}
    return made


def page(
    replays: list[JsonDict], checks: list[JsonDict] | None = None, title: str = "Obstacle avoidance"
) -> JsonDict:
    return {
        "grading": None if checks is None else grading(checks, field_ready=False),
        "replays": replays,
        "title": title,
        "generated_by": "rclpy agents course 0.1.0",
    }


def failing_page() -> JsonDict:
    return page([goal_run(), wall_run()], failing_checks())


def graph(*topics: str) -> str:
    """A node that listens to topics which nobody publishes."""
    ends = [Endpoint("subscription", "/porter/eyes", topic, "a_msgs/msg/B") for topic in topics]
    none: Any = None
    scenario, outcome = load_scenario("demo_wall"), Outcome(COMPLETED)
    return graph_html(Recording(scenario, none, 1, 2.0, (), (), none, outcome, tuple(ends)))


def drive_page() -> JsonDict:
    return page([wall_run()], title="Wall ahead")


def odd_page() -> JsonDict:
    long = {"message": "x" * 10_000, "expected": HOSTILE, "actual": "y" * 3000, "help": HOSTILE}
    checks = [
        check("hostile", HOSTILE, "fail", scenario=HOSTILE, time=1.0, **long),
        check("unknown", "An outcome nobody knows", "constructor"),
    ]
    return page([odd_run(), replay()], checks, title=HOSTILE) | {
        "generated_by": HOSTILE,
        "graphs": [graph(HOSTILE)],
        "odd": [float("nan"), float("inf"), np.float32(1.5), "\ud800"],
    }
