"""The endpoints that the student's nodes create, as they are created."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any

import rclpy.action
import rclpy.node

from .frames import EndpointReport

HIDDEN_TOPICS = {"/parameter_events", "/rosout", "/clock"}
PARAMETER_SERVICES = (
    "/describe_parameters",
    "/get_parameter_types",
    "/get_parameters",
    "/list_parameters",
    "/set_parameters",
    "/set_parameters_atomically",
    "/get_type_description",
)
CREATED_BY = {
    "publisher": "create_publisher",
    "subscription": "create_subscription",
    "service": "create_service",
    "client": "create_client",
}

ACTIONS = {"action server": rclpy.action.ActionServer, "action client": rclpy.action.ActionClient}
GOALS = "/_action/send_goal"  # the service after an action's name

OnEndpoint = Callable[[str, Any, Any], None]  # kind, node, endpoint


class EndpointWatch:
    """Calls back for each publisher, subscription, service, client and action of a node's."""

    def __init__(self, react: OnEndpoint) -> None:
        self._react = react
        self._inside = False  # what the reaction itself creates is not the student's

    def install(self) -> None:
        """Watch every node of this process."""
        for kind, method in CREATED_BY.items():
            self._watch(kind, method)
        for kind, cls in ACTIONS.items():
            self._watch_action(kind, cls)

    def _watch_action(self, kind: str, cls: Any) -> None:
        create = cls.__init__

        @functools.wraps(create)
        def watched(end: Any, *args: Any, **kwargs: Any) -> None:
            create(end, *args, **kwargs)
            name = inspect.signature(create).bind(end, *args, **kwargs).arguments["action_name"]
            end._course_name = end._node.resolve_service_name(name + GOALS).removesuffix(GOALS)
            self._react(kind, end._node, end)

        cls.__init__ = watched

    def _watch(self, kind: str, method: str) -> None:
        cls: Any = rclpy.node.Node
        create = getattr(cls, method)

        def watched(node: Any, *args: Any, **kwargs: Any) -> Any:
            endpoint = create(node, *args, **kwargs)
            if not self._inside:
                self._inside = True
                try:
                    self._react(kind, node, endpoint)
                finally:
                    self._inside = False
            return endpoint

        watched.__name__, watched.__doc__ = method, create.__doc__
        setattr(cls, method, watched)


def report(
    kind: str, node: Any, endpoint: Any, mismatch: str = "", process: int = 0
) -> EndpointReport:
    """Describe an endpoint for the judge."""
    owner = node.get_fully_qualified_name()
    if kind in ACTIONS:
        name, type = endpoint._course_name, type_name(endpoint._action_type)
        return EndpointReport(kind, owner, name, type, process=process)
    is_topic = kind in ("publisher", "subscription")
    # a destroyed endpoint, as it is after an exception, has no name any more
    endpoint._course_name = endpoint.topic_name if is_topic else endpoint.service_name
    if kind in ("service", "client"):
        name, type = endpoint.service_name, type_name(endpoint.srv_type)
        return EndpointReport(kind, owner, name, type, process=process)
    qos = endpoint.qos_profile
    return EndpointReport(
        kind,
        owner,
        endpoint.topic_name,
        type_name(endpoint.msg_type),
        qos.reliability.name.lower(),
        qos.durability.name.lower(),
        int(qos.depth),  # rclpy takes True for 1
        mismatch,
        process,
    )


def is_parameter_service(name: str) -> bool:
    """Return whether it is one of the services that every node has."""
    return name.endswith(PARAMETER_SERVICES)


def type_name(ros_type: Any) -> str:
    """Return the ROS name of a generated class: geometry_msgs/msg/Twist."""
    # a class of the program's own, derived from a generated one, is of that one's type to rclpy
    made = [cls for cls in ros_type.__mro__ if type(cls) is type(ros_type)][-1]
    package, kind = made.__module__.split(".")[:2]
    return f"{package}/{kind}/{made.__name__}"
