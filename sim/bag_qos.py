"""The quality of service that a bag says a topic's publisher offered, as rosbag2 writes it.

`ros2 bag play` and RViz publish and subscribe with it: without, /tf_static is volatile, and who
comes later never hears it.
"""

from typing import Any


def profile(*, reliable: bool, latched: bool, depth: int) -> tuple[Any, ...]:
    """Return the profiles of a connection for rosbags' Writer: one."""
    from rosbags.interfaces import (  # noqa: PLC0415  (60 ms, only where a bag is written)
        Qos,
        QosDurability,
        QosHistory,
        QosLiveliness,
        QosReliability,
        QosTime,
    )

    for_ever = QosTime(9223372036, 854775807)
    return (
        Qos(
            history=QosHistory.KEEP_LAST,
            depth=depth,
            reliability=QosReliability.RELIABLE if reliable else QosReliability.BEST_EFFORT,
            durability=QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
            deadline=for_ever,
            lifespan=for_ever,
            liveliness=QosLiveliness.AUTOMATIC,
            liveliness_lease_duration=for_ever,
            avoid_ros_namespace_conventions=False,
        ),
    )
