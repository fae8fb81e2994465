"""The goals of an action server: their states, and what may follow which (rcl_action/goal_*.c)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .enums import GoalEvent
from .errors import RCLError
from .handles import Destroyable

if TYPE_CHECKING:
    from .action_server import ActionServer

ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = 1, 2, 3, 4, 5, 6
TERMINAL = (SUCCEEDED, CANCELED, ABORTED)
NEXT = {
    (ACCEPTED, GoalEvent.EXECUTE): EXECUTING,
    (ACCEPTED, GoalEvent.CANCEL_GOAL): CANCELING,
    (EXECUTING, GoalEvent.CANCEL_GOAL): CANCELING,
    (EXECUTING, GoalEvent.SUCCEED): SUCCEEDED,
    (EXECUTING, GoalEvent.ABORT): ABORTED,
    (CANCELING, GoalEvent.SUCCEED): SUCCEEDED,
    (CANCELING, GoalEvent.ABORT): ABORTED,
    (CANCELING, GoalEvent.CANCELED): CANCELED,
}


class ActionGoalHandle(Destroyable):
    """One goal of an action server."""

    def __init__(self, server: ActionServer, info: Any) -> None:
        self.id = bytes(info.goal_id.uuid)
        self.stamp = server.accept(self)  # [ns] of the server's clock
        self._status = ACCEPTED

    def get_status(self) -> int:
        """Return its state, a number of action_msgs/msg/GoalStatus."""
        return self._status

    def is_active(self) -> bool:
        """Return whether it has not come to an end."""
        return self._status not in TERMINAL

    def is_cancelable(self) -> bool:
        """Return whether it may still be canceled."""
        return (self._status, GoalEvent.CANCEL_GOAL) in NEXT

    def update_goal_state(self, event: GoalEvent) -> None:
        """Go on to the next state.

        Raises RCLError: the event can't come in this state.
        """
        following = NEXT.get((self._status, GoalEvent(event)))
        if following is None:
            raise RCLError("Failed to update goal state: goal_handle attempted invalid transition")
        self._status = following
