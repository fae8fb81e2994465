"""The enumerations of rclpy's native module, with the numbers of rcl and rmw (Jazzy)."""

from __future__ import annotations

from enum import IntEnum
from types import SimpleNamespace

RCL_DEFAULT_DOMAIN_ID = 2**64 - 1
RMW_DURATION_INFINITE = 2**63 - 1
RMW_QOS_DEADLINE_BEST_AVAILABLE = 2**63 - 2
RMW_QOS_LIVELINESS_LEASE_DURATION_BEST_AVAILABLE = 2**63 - 2


class NativeEnum(IntEnum):
    """An enumeration that is shown as pybind11 shows it."""

    def __str__(self) -> str:
        return f"{type(self).__name__}.{self.name}"


class ClockType(NativeEnum):
    """rcl_clock_type_t."""

    UNINITIALIZED = 0
    ROS_TIME = 1
    SYSTEM_TIME = 2
    STEADY_TIME = 3


class ClockChange(NativeEnum):
    """rcl_clock_change_t."""

    ROS_TIME_NO_CHANGE = 1
    ROS_TIME_ACTIVATED = 2
    ROS_TIME_DEACTIVATED = 3
    SYSTEM_TIME_NO_CHANGE = 4


class Severity(NativeEnum):
    """RCUTILS_LOG_SEVERITY."""

    RCUTILS_LOG_SEVERITY_UNSET = 0
    RCUTILS_LOG_SEVERITY_DEBUG = 10
    RCUTILS_LOG_SEVERITY_INFO = 20
    RCUTILS_LOG_SEVERITY_WARN = 30
    RCUTILS_LOG_SEVERITY_ERROR = 40
    RCUTILS_LOG_SEVERITY_FATAL = 50


class QoSCompatibility(NativeEnum):
    """rmw_qos_compatibility_type_t."""

    OK = 0
    WARNING = 1
    ERROR = 2


class PublisherEvent(NativeEnum):
    """rcl_publisher_event_type_t."""

    RCL_PUBLISHER_OFFERED_DEADLINE_MISSED = 0
    RCL_PUBLISHER_LIVELINESS_LOST = 1
    RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS = 2
    RCL_PUBLISHER_INCOMPATIBLE_TYPE = 3
    RCL_PUBLISHER_MATCHED = 4


class SubscriptionEvent(NativeEnum):
    """rcl_subscription_event_type_t."""

    RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED = 0
    RCL_SUBSCRIPTION_LIVELINESS_CHANGED = 1
    RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS = 2
    RCL_SUBSCRIPTION_MESSAGE_LOST = 3
    RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE = 4
    RCL_SUBSCRIPTION_MATCHED = 5


class SignalHandlerOptions(NativeEnum):
    """rclpy::SignalHandlerOptions."""

    NO = 0
    SIGINT = 1
    SIGTERM = 2
    ALL = 3


class GoalEvent(NativeEnum):
    """rcl_action_goal_event_t."""

    EXECUTE = 0
    CANCEL_GOAL = 1
    SUCCEED = 2
    ABORT = 3
    CANCELED = 4


class TransitionCallbackReturnType(NativeEnum):
    """What a transition's callback may return; lifecycle_msgs/msg/Transition has the numbers."""

    SUCCESS = 97
    FAILURE = 98
    ERROR = 99

    def to_label(self) -> str:
        """Return the transition that follows."""
        return f"transition_{self.name.lower()}"


class PolicyKind(NativeEnum):
    """rmw_qos_policy_kind_t."""

    RMW_QOS_POLICY_INVALID = 1
    RMW_QOS_POLICY_DURABILITY = 2
    RMW_QOS_POLICY_DEADLINE = 4
    RMW_QOS_POLICY_LIVELINESS = 8
    RMW_QOS_POLICY_RELIABILITY = 16
    RMW_QOS_POLICY_HISTORY = 32
    RMW_QOS_POLICY_LIFESPAN = 64
    RMW_QOS_POLICY_DEPTH = 128
    RMW_QOS_POLICY_LIVELINESS_LEASE_DURATION = 256
    RMW_QOS_POLICY_AVOID_ROS_NAMESPACE_CONVENTIONS = 512


class ServiceIntrospectionState(NativeEnum):
    """rcl_service_introspection_state_t."""

    OFF = 0
    METADATA = 1
    CONTENTS = 2


# under the names that rclpy knows
PublisherEvent.__name__ = "rcl_publisher_event_type_t"
SubscriptionEvent.__name__ = "rcl_subscription_event_type_t"
PolicyKind.__name__ = "rmw_qos_policy_kind_t"
Severity.__name__ = "RCUTILS_LOG_SEVERITY"
service_introspection = SimpleNamespace(ServiceIntrospectionState=ServiceIntrospectionState)
