"""An action's client: three service clients and two subscriptions (rcl_action/action_client.c)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .arguments import ACTION
from .endpoints import Subscription
from .handles import Destroyable
from .qos import rmw_qos_profile_t
from .services import Client
from .wait_set import WaitSet

if TYPE_CHECKING:
    from .node import Node

SUFFIXES = {
    "goal": "/_action/send_goal",
    "cancel": "/_action/cancel_goal",
    "result": "/_action/get_result",
    "feedback": "/_action/feedback",
    "status": "/_action/status",
}


def action_name(node: Node, name: str) -> str:
    """Return the full name of an action.

    Raises
    ------
    ValueError
        It is not valid.
    """
    return node.resolve(name, ACTION)


class ActionClient(Destroyable):
    """What asks for goals, for their results, and to cancel them."""

    def __init__(
        self,
        node: Node,
        action: Any,
        name: str,
        goal: rmw_qos_profile_t,
        result: rmw_qos_profile_t,
        cancel: rmw_qos_profile_t,
        feedback: rmw_qos_profile_t,
        status: rmw_qos_profile_t,
    ) -> None:
        full = action_name(node, name)
        impl = action.Impl
        self._goal = Client(node, impl.SendGoalService, full + SUFFIXES["goal"], goal)
        self._cancel = Client(node, impl.CancelGoalService, full + SUFFIXES["cancel"], cancel)
        self._result = Client(node, impl.GetResultService, full + SUFFIXES["result"], result)
        self._feedback = Subscription(
            node, impl.FeedbackMessage, full + SUFFIXES["feedback"], feedback
        )
        self._status = Subscription(node, impl.GoalStatusMessage, full + SUFFIXES["status"], status)
        self._clients = (self._goal, self._cancel, self._result)
        self._subscriptions = (self._feedback, self._status)
        self._indices: tuple[tuple[int, ...], tuple[int, ...]] = ((), ())

    def send_goal_request(self, request: Any) -> int:
        """Ask for a goal; return the number of the request."""
        return self._goal.send_request(request)

    def send_cancel_request(self, request: Any) -> int:
        """Ask to cancel goals; return the number of the request."""
        return self._cancel.send_request(request)

    def send_result_request(self, request: Any) -> int:
        """Ask for a result; return the number of the request."""
        return self._result.send_request(request)

    def take_goal_response(self, cls: Any) -> tuple[int | None, Any]:
        """Return the number and the answer to a request for a goal."""
        return _taken(self._goal, cls)

    def take_cancel_response(self, cls: Any) -> tuple[int | None, Any]:
        """Return the number and the answer to a request to cancel."""
        return _taken(self._cancel, cls)

    def take_result_response(self, cls: Any) -> tuple[int | None, Any]:
        """Return the number and the answer to a request for a result."""
        return _taken(self._result, cls)

    def take_feedback(self, cls: Any) -> Any:
        """Return a message; None if there is none."""
        taken = self._feedback.take_message(cls, False)
        return None if taken is None else taken[0]

    def take_status(self, cls: Any) -> Any:
        """Return a message; None if there is none."""
        taken = self._status.take_message(cls, False)
        return None if taken is None else taken[0]

    def is_action_server_available(self) -> bool:
        """Return whether somebody serves the action, with all that belongs to it."""
        services = all(client.service_server_is_available() for client in self._clients)
        topics = all(subscription.peers for subscription in self._subscriptions)
        return services and topics

    def get_num_entities(self) -> tuple[int, int, int, int, int]:
        """Return numbers: subscriptions, guard conditions, timers, clients, services."""
        return 2, 0, 0, 3, 0

    def add_to_waitset(self, wait_set: WaitSet) -> None:
        """Let a wait set wait for all of it."""
        self._indices = (
            tuple(wait_set.add_subscription(end) for end in self._subscriptions),
            tuple(wait_set.add_client(end) for end in self._clients),
        )

    def is_ready(self, wait_set: WaitSet) -> tuple[bool, ...]:
        """Tell what is ready: feedback, status, answers to goal, cancel and result."""
        subscriptions, clients = self._indices
        return (
            *(wait_set.is_ready("subscription", index) for index in subscriptions),
            *(wait_set.is_ready("client", index) for index in clients),
        )

    def _destroy(self) -> None:
        for end in (*self._clients, *self._subscriptions):
            end.destroy_when_not_in_use()


def _taken(client: Client, cls: Any) -> tuple[int | None, Any]:
    info, response = client.take_response(cls)
    return (None, None) if info is None else (info.request_id.sequence_number, response)
