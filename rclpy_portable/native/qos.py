"""Quality of service: profiles, and whether two of them can talk (rmw/qos_profiles.h, Jazzy)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .enums import RMW_DURATION_INFINITE, PolicyKind, QoSCompatibility

KEEP_ALL = 2
RELIABLE, BEST_EFFORT, RELIABILITY_UNKNOWN, RELIABILITY_BEST = 1, 2, 3, 4
TRANSIENT_LOCAL, VOLATILE, DURABILITY_BEST = 1, 2, 4
AUTOMATIC, MANUAL_BY_TOPIC = 1, 3
BEST = 2**63 - 2
DURATIONS = ("lifespan", "deadline", "liveliness_lease_duration")
FIELDS = (
    "history", "depth", "reliability", "durability", "lifespan", "deadline", "liveliness",
    "liveliness_lease_duration", "avoid_ros_namespace_conventions",
)  # fmt: skip
PROFILES = {  # history, depth, reliability, durability, lifespan, deadline, liveliness, lease
    "unknown": (3, 0, 3, 3, 0, 0, 4, 0),
    "default": (1, 10, 1, 2, 0, 0, 0, 0),
    "system_default": (0, 0, 0, 0, 0, 0, 0, 0),
    "sensor_data": (1, 5, 2, 2, 0, 0, 0, 0),
    "services_default": (1, 10, 1, 2, 0, 0, 0, 0),
    "parameters": (1, 1000, 1, 2, 0, 0, 0, 0),
    "parameter_events": (1, 1000, 1, 2, 0, 0, 0, 0),
    "best_available": (1, 10, 4, 4, 0, BEST, 5, BEST),
}
ACTION_STATUS = (1, 1, 1, 1, 0, 0, 0, 0)  # rcl_action_qos_profile_status_default


class rmw_qos_profile_t:  # noqa: N801  (its name in rclpy)
    """A profile; durations in nanoseconds, 0 stands for the middleware's default."""

    history: int
    depth: int
    reliability: int
    durability: int
    lifespan: int
    deadline: int
    liveliness: int
    liveliness_lease_duration: int
    avoid_ros_namespace_conventions: bool

    def __init__(self, *values: Any) -> None:
        for name, value in zip(FIELDS, values, strict=True):
            setattr(self, name, getattr(value, "nanoseconds", value))

    @staticmethod
    def predefined(name: str) -> rmw_qos_profile_t:
        """Return a profile of rmw by its name, such as `qos_profile_default`."""
        try:
            values = PROFILES[name.removeprefix("qos_profile_")]
        except KeyError:
            raise ValueError(f"Requested unknown rmw_qos_profile: {name}") from None
        return rmw_qos_profile_t(*values, False)

    def to_dict(self) -> dict[str, Any]:
        """Return the arguments of rclpy's QoSProfile."""
        from rclpy.duration import Duration  # noqa: PLC0415  (rclpy imports this package)

        made: dict[str, Any] = {name: getattr(self, name) for name in FIELDS}
        for name in DURATIONS:
            made[name] = Duration(nanoseconds=made[name])
        return made

    def resolved(self) -> rmw_qos_profile_t:
        """Return the profile that an endpoint has in the end: defaults filled in."""
        made = rmw_qos_profile_t(*(getattr(self, name) for name in FIELDS))
        made.reliability = made.reliability or RELIABLE
        made.durability = made.durability or VOLATILE
        made.liveliness = made.liveliness or AUTOMATIC
        for name in DURATIONS:
            setattr(made, name, getattr(made, name) or RMW_DURATION_INFINITE)
        return made


def action_profile(name: str) -> dict[str, Any]:
    """Return a profile of actions: rclpy_action_get_rmw_qos_profile."""
    if name != "rcl_action_qos_profile_status_default":
        raise RuntimeError(f"Requested unknown rmw_qos_profile: {name}")
    return rmw_qos_profile_t(*ACTION_STATUS, False).to_dict()


@dataclass
class QoSCheckCompatibleResult:
    """Can two profiles talk, and why not."""

    compatibility: QoSCompatibility = QoSCompatibility.OK
    reason: str = ""


def conflicts(pub: rmw_qos_profile_t, sub: rmw_qos_profile_t) -> list[tuple[PolicyKind, str]]:
    """Return the policies in which an offer falls short of a request, most basic first."""
    found = []
    if pub.reliability == BEST_EFFORT and sub.reliability == RELIABLE:
        said = "Best effort publisher and reliable subscription"
        found.append((PolicyKind.RMW_QOS_POLICY_RELIABILITY, said))
    if pub.durability == VOLATILE and sub.durability == TRANSIENT_LOCAL:
        said = "Volatile publisher and transient local subscription"
        found.append((PolicyKind.RMW_QOS_POLICY_DURABILITY, said))
    if _is_finite(sub.deadline):
        if not _is_finite(pub.deadline):
            said = "Subscription has a deadline, but publisher does not"
            found.append((PolicyKind.RMW_QOS_POLICY_DEADLINE, said))
        elif sub.deadline < pub.deadline:
            said = "Subscription deadline is less than publisher deadline"
            found.append((PolicyKind.RMW_QOS_POLICY_DEADLINE, said))
    if pub.liveliness == AUTOMATIC and sub.liveliness == MANUAL_BY_TOPIC:
        said = "Publisher's liveliness is automatic and subscription's is manual by topic"
        found.append((PolicyKind.RMW_QOS_POLICY_LIVELINESS, said))
    if _is_finite(sub.liveliness_lease_duration):
        if not _is_finite(pub.liveliness_lease_duration):
            said = "Subscription has a liveliness lease duration, but publisher does not"
            found.append((PolicyKind.RMW_QOS_POLICY_LIVELINESS, said))
        elif sub.liveliness_lease_duration < pub.liveliness_lease_duration:
            said = "Subscription liveliness lease duration is less than publisher"
            found.append((PolicyKind.RMW_QOS_POLICY_LIVELINESS, said))
    return found


def doubts(pub: rmw_qos_profile_t, sub: rmw_qos_profile_t) -> list[str]:
    """Return what can't be told, because one of the two has not decided on a policy."""
    found = []
    for name, unsure in (("reliability", (0, 3)), ("durability", (0, 3)), ("liveliness", (0, 4))):
        offered, asked = getattr(pub, name), getattr(sub, name)
        strict = {"reliability": RELIABLE, "durability": TRANSIENT_LOCAL, "liveliness": 3}[name]
        weak = {"reliability": BEST_EFFORT, "durability": VOLATILE, "liveliness": 1}[name]
        if name == "liveliness" and (offered == 0 or asked == 0):
            continue  # every middleware's default is automatic
        if (offered in unsure and asked in (*unsure, strict)) or (
            asked in unsure and offered == weak
        ):
            found.append(f"WARNING: the {name} of one of the two is not known;")
    return found


def check_compatible(pub: rmw_qos_profile_t, sub: rmw_qos_profile_t) -> QoSCheckCompatibleResult:
    """Return whether a publisher and a subscription can talk: rclpy_qos_check_compatible."""
    errors = [f"ERROR: {said};" for _, said in conflicts(pub, sub)]
    if errors:
        return QoSCheckCompatibleResult(QoSCompatibility.ERROR, "".join(errors))
    warnings = doubts(pub, sub)
    if warnings:
        return QoSCheckCompatibleResult(QoSCompatibility.WARNING, "".join(warnings))
    return QoSCheckCompatibleResult()


def _is_finite(duration: int) -> bool:
    return 0 < duration < BEST
