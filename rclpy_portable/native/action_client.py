"""An action's client: three service clients and two subscriptions (rcl_action/action_client.c)."""

from __future__ import annotations

from functools import partial
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

    Raises ValueError: it is not valid.
    """
    return node.resolve(name, ACTION)


class ActionClient(Destroyable):
    """What asks for goals, for their results, and to cancel them."""

    def __init__(self, node: Node, action: Any, name: str, *profiles: rmw_qos_profile_t) -> None:
        goal, result, cancel, feedback, status = profiles
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
        # what rclpy calls: a request gets a number, a response comes with its own
        self.send_goal_request = self._goal.send_request
        self.send_cancel_request = self._cancel.send_request
        self.send_result_request = self._result.send_request
        self.take_goal_response = partial(_taken, self._goal)
        self.take_cancel_response = partial(_taken, self._cancel)
        self.take_result_response = partial(_taken, self._result)
        self.take_feedback = partial(_message, self._feedback)
        self.take_status = partial(_message, self._status)

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


def _message(subscription: Subscription, cls: Any) -> Any:
    taken = subscription.take_message(cls, False)
    return None if taken is None else taken[0]
