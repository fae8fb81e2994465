"""What rclpy asks of its native module `_rclpy_pybind11`, in Python: rcl and DDS of one process.

The names are those of rclpy 7.1 (Jazzy). What it does not have: the EventsExecutor, introspection
of services, definitions and hashes of types, security enclaves, log files.
"""
# ruff: noqa: F401  (rclpy looks for all that is imported here)

from __future__ import annotations

from typing import Any

from .. import cdr
from . import logging, names, queries
from .action_client import ActionClient
from .action_server import ActionServer
from .arguments import SERVICE, TOPIC, without_ros_arguments
from .clocks import Clock, ClockEvent, rcl_duration_t, rcl_time_point_t
from .context import Context, configure_logging
from .endpoints import Publisher, Subscription
from .enums import (
    RCL_DEFAULT_DOMAIN_ID,
    RMW_DURATION_INFINITE,
    RMW_QOS_DEADLINE_BEST_AVAILABLE,
    RMW_QOS_LIVELINESS_LEASE_DURATION_BEST_AVAILABLE,
    ClockChange,
    ClockType,
    GoalEvent,
    PolicyKind,
    PublisherEvent,
    QoSCompatibility,
    Severity,
    SignalHandlerOptions,
    SubscriptionEvent,
    TransitionCallbackReturnType,
    service_introspection,
)
from .errors import (
    InvalidHandle,
    NodeNameNonExistentError,
    NotImplementedError,
    RCLError,
    RCLInvalidROSArgsError,
    RCUtilsError,
    RMWError,
    UnknownROSArgsError,
    UnsupportedEventTypeError,
)
from .events import (
    EventHandle,
    rmw_incompatible_type_status_t,
    rmw_liveliness_changed_status_t,
    rmw_liveliness_lost_status_t,
    rmw_matched_status_t,
    rmw_message_lost_status_t,
    rmw_offered_deadline_missed_status_t,
    rmw_requested_deadline_missed_status_t,
    rmw_requested_qos_incompatible_event_status_t,
)
from .goals import ActionGoalHandle
from .handles import Destroyable
from .lifecycle import LifecycleStateMachine
from .node import Node
from .qos import QoSCheckCompatibleResult, action_profile, check_compatible, rmw_qos_profile_t
from .services import Client, Service, TypeDescriptionService, rmw_request_id_t, rmw_service_info_t
from .signals import (
    get_current_signal_handlers_options,
    install_signal_handlers,
    register_sigint_guard_condition,
    uninstall_signal_handlers,
    unregister_sigint_guard_condition,
)
from .timers import ContextTimer as Timer
from .wait_set import GuardCondition, WaitSet

RCUTILS_LOG_SEVERITY = Severity
rcl_publisher_event_type_t = PublisherEvent
rcl_subscription_event_type_t = SubscriptionEvent
rmw_qos_policy_kind_t = PolicyKind

rclpy_action_get_rmw_qos_profile = action_profile
rclpy_qos_check_compatible = check_compatible
rclpy_remove_ros_args = without_ros_arguments
rclpy_remap_topic_name = Node.remap
rclpy_assert_liveliness = Publisher.assert_liveliness
rclpy_deserialize = cdr.deserialize

rclpy_get_validation_error_for_topic_name = names.topic_name_problem
rclpy_get_validation_error_for_full_topic_name = names.full_topic_name_problem
rclpy_get_validation_error_for_namespace = names.namespace_problem
rclpy_get_validation_error_for_node_name = names.node_name_problem
rclpy_expand_topic_name = names.expand

rclpy_get_topic_names_and_types = queries.topics
rclpy_get_service_names_and_types = queries.services
rclpy_get_publisher_names_and_types_by_node = queries.published_by
rclpy_get_subscriber_names_and_types_by_node = queries.subscribed_by
rclpy_get_service_names_and_types_by_node = queries.served_by
rclpy_get_client_names_and_types_by_node = queries.asked_by
rclpy_get_publishers_info_by_topic = queries.publishers_of
rclpy_get_subscriptions_info_by_topic = queries.subscriptions_of

rclpy_logging_configure = configure_logging
rclpy_logging_shutdown = logging.clear
rclpy_logging_get_logger_level = logging.get_logger_level
rclpy_logging_get_logger_effective_level = logging.get_logger_effective_level
rclpy_logging_logger_is_enabled_for = logging.logger_is_enabled_for
rclpy_logging_set_logger_level = logging.set_logger_level
rclpy_logging_severity_level_from_string = logging.severity_level_from_string
rclpy_logging_rcutils_log = logging.log
rclpy_logging_get_separator_string = logging.get_separator_string
rclpy_logging_get_logging_directory = logging.get_logging_directory


class EventsExecutor:
    """There is none: it would wait in native code."""

    def __init__(self, _context: Any) -> None:
        raise NotImplementedError("the portable runtime has no EventsExecutor")


def rclpy_resolve_name(node: Node, name: str, only_expand: bool, is_service: bool) -> str:
    """Return the full name of a topic or service, remapped unless only to be expanded."""
    try:
        return node.resolve(name, SERVICE if is_service else TOPIC, remap=not only_expand)
    except ValueError as error:
        raise RCLError(f"failed to resolve name: {error}") from None


def rclpy_serialize(message: Any, _cls: Any) -> bytes:
    """Return a message's CDR."""
    return cdr.serialize(message)


def rclpy_get_rmw_implementation_identifier() -> str:
    """Return the name of the middleware."""
    return "rmw_portable"


def rclpy_logging_initialize() -> None:
    """Nothing has to be made ready."""


def rclpy_logging_fini() -> None:
    """Nothing has to be put away."""


def rclpy_logging_rosout_add_sublogger(_name: str, _child: str) -> bool:
    """Nobody publishes /rosout here."""
    return False


def rclpy_logging_rosout_remove_sublogger(_name: str, _child: str) -> None:
    """Nobody publishes /rosout here."""
