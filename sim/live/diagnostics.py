"""The robot's health as a diagnostic_msgs/DiagnosticArray."""

from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from sim.live.health import Health


def diagnostics(health: Health, *, stamp: int, name: str, hardware: str, paused: bool) -> Any:
    """Return the message.

    Parameters
    ----------
    health
        What was measured since the last message.
    stamp
        ROS time [ns].
    name, hardware
        The name of the node; which robot it is.
    paused
        Time stands still, so nothing is sent.
    """
    message = DiagnosticArray()
    seconds, nanoseconds = divmod(stamp, 10**9)
    message.header.stamp = Time(sec=seconds, nanosec=nanoseconds)
    message.status = [_pace(health, name, hardware, paused)]
    for topic, (target, actual) in health.rates.items():
        aim = f" of {target:.1f}" if target else ""
        status = _status(f"{name}: {topic}", hardware, f"{actual:.1f}{aim} Hz")
        status.values = _values({"target [Hz]": target, "actual [Hz]": actual})
        message.status.append(status)
    return message


def _pace(health: Health, name: str, hardware: str, paused: bool) -> Any:
    text = "paused" if paused else "keeps up"
    status = _status(f"{name}: pace", hardware, text)
    if not health.keeps_up:
        status.level = DiagnosticStatus.WARN
        status.message = f"cannot keep up: {health.overruns} overruns in {health.seconds:.1f} s"
    status.values = _values(
        {
            "worst lateness [ms]": health.worst_lateness * 1e3,
            "overruns": health.overruns,
            "slipped [ms]": health.slipped * 1e3,
        }
    )
    return status


def _status(name: str, hardware: str, message: str) -> Any:
    level = DiagnosticStatus.OK
    return DiagnosticStatus(level=level, name=name, hardware_id=hardware, message=message)


def _values(values: dict[str, float]) -> list[Any]:
    return [
        KeyValue(key=key, value=f"{value:.3f}".removesuffix(".000"))
        for key, value in values.items()
    ]
