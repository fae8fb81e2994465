"""An action's server: three services, two publishers and its goals (rcl_action/action_server.c)."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from .action_client import SUFFIXES, action_name
from .clocks import Clock
from .endpoints import Publisher
from .errors import RCLError
from .goals import ActionGoalHandle
from .handles import Destroyable
from .qos import rmw_qos_profile_t
from .services import Service, rmw_request_id_t
from .timers import Timer
from .wait_set import WaitSet

if TYPE_CHECKING:
    from .node import Node

# the answers of action_msgs/srv/CancelGoal
ERROR_NONE, ERROR_REJECTED, ERROR_UNKNOWN_GOAL_ID, ERROR_GOAL_TERMINATED = 0, 1, 2, 3
SECOND = 10**9  # [ns]


class ActionServer(Destroyable):
    """What accepts goals, works on them, and tells how they ended."""

    def __init__(
        self,
        node: Node,
        clock: Clock,
        action: Any,
        name: str,
        goal: rmw_qos_profile_t,
        result: rmw_qos_profile_t,
        cancel: rmw_qos_profile_t,
        feedback: rmw_qos_profile_t,
        status: rmw_qos_profile_t,
        result_timeout: float,
    ) -> None:
        full = action_name(node, name)
        impl = action.Impl
        self._clock = clock
        self._goal = Service(node, impl.SendGoalService, full + SUFFIXES["goal"], goal)
        self._cancel = Service(node, impl.CancelGoalService, full + SUFFIXES["cancel"], cancel)
        self._result = Service(node, impl.GetResultService, full + SUFFIXES["result"], result)
        self._feedback = Publisher(
            node, impl.FeedbackMessage, full + SUFFIXES["feedback"], feedback
        )
        self._status = Publisher(node, impl.GoalStatusMessage, full + SUFFIXES["status"], status)
        self._services = (self._goal, self._cancel, self._result)
        self._timeout = round(result_timeout * SECOND)  # [ns] that results are kept; < 0: for ever
        self._expiry = Timer(clock, max(self._timeout, 0), False)
        self._goals: list[ActionGoalHandle] = []
        self._ended: dict[bytes, int] = {}  # goals that came to an end: when [ns]
        self._indices: tuple[int, ...] = ()
        self._timer_index = 0
        # what rclpy calls
        self.take_goal_request = partial(_taken, self._goal)
        self.take_cancel_request = partial(_taken, self._cancel)
        self.take_result_request = partial(_taken, self._result)
        self.send_goal_response = partial(_answer, self._goal)
        self.send_cancel_response = partial(_answer, self._cancel)
        self.send_result_response = partial(_answer, self._result)
        self.publish_feedback = self._feedback.publish

    def publish_status(self) -> None:
        """Tell the states of all goals."""
        from action_msgs.msg import GoalStatus, GoalStatusArray  # noqa: PLC0415

        message = GoalStatusArray()
        for goal in self._goals:
            status = GoalStatus(status=goal.get_status())
            _describe(status.goal_info, goal)
            message.status_list.append(status)
        self._status.publish(message)

    def accept(self, goal: ActionGoalHandle) -> int:
        """Take in a goal; return the time [ns].

        Raises RCLError: there is one of that id.
        """
        if self._find(goal.id):
            raise RCLError("Failed to accept new goal: goal ID already exists")
        self._goals.append(goal)
        return self._clock.now()

    def goal_exists(self, info: Any) -> bool:
        """Return whether there is a goal of this id."""
        return self._find(bytes(info.goal_id.uuid)) is not None

    def notify_goal_done(self) -> None:
        """Note that goals have come to an end: their results expire."""
        now = self._clock.now()
        for goal in self._goals:
            if not goal.is_active():
                self._ended.setdefault(goal.id, now)
        self._set_expiry()

    def expire_goals(self, most: int) -> tuple[Any, ...]:
        """Forget goals that ended long ago; return what is known of them."""
        from action_msgs.msg import GoalInfo  # noqa: PLC0415

        if self._timeout < 0:
            return ()
        now = self._clock.now()
        expired: list[Any] = []
        for goal in list(self._goals):
            ended = self._ended.get(goal.id)
            if len(expired) < most and ended is not None and now - ended >= self._timeout:
                info = GoalInfo()
                _describe(info, goal)
                expired.append(info)
                self._goals.remove(goal)
                del self._ended[goal.id]
        self._set_expiry()
        return tuple(expired)

    def process_cancel_request(self, request: Any, response_cls: Any) -> Any:
        """Return which goals a request is about: one, all, or those accepted until some time."""
        asked = request.goal_info
        uuid, stamp = bytes(asked.goal_id.uuid), _nanoseconds(asked.stamp)
        response = response_cls()
        if any(uuid) and not stamp:
            goal = self._find(uuid)
            chosen = [goal] if goal is not None and goal.is_cancelable() else []
            if goal is None:
                response.return_code = ERROR_UNKNOWN_GOAL_ID
            elif not chosen:
                response.return_code = ERROR_GOAL_TERMINATED
        else:
            chosen = [
                goal
                for goal in self._goals
                if goal.is_cancelable() and (not stamp or goal.stamp <= stamp or goal.id == uuid)
            ]
        for goal in chosen:
            response.goals_canceling.append(type(asked)())
            _describe(response.goals_canceling[-1], goal)
        return response

    def get_num_entities(self) -> tuple[int, int, int, int, int]:
        """Return numbers: subscriptions, guard conditions, timers, clients, services."""
        return 0, 0, 1, 0, 3

    def add_to_waitset(self, wait_set: WaitSet) -> None:
        """Let a wait set wait for all of it."""
        self._indices = tuple(wait_set.add_service(end) for end in self._services)
        self._timer_index = wait_set.add_timer(self._expiry)

    def is_ready(self, wait_set: WaitSet) -> tuple[bool, ...]:
        """Tell what is ready: requests for goals, to cancel, for results; expired goals."""
        return (
            *(wait_set.is_ready("service", index) for index in self._indices),
            wait_set.is_ready("timer", self._timer_index),
        )

    def _find(self, uuid: bytes) -> ActionGoalHandle | None:
        return next((goal for goal in self._goals if goal.id == uuid), None)

    def _set_expiry(self) -> None:
        """Set the timer to when the next result expires."""
        if self._timeout < 0 or not self._ended:
            self._expiry.cancel_timer()
            return
        left = min(self._ended.values()) + self._timeout - self._clock.now()
        self._expiry.change_timer_period(max(left, 0))
        self._expiry.reset_timer()

    def _destroy(self) -> None:
        for end in (*self._services, self._feedback, self._status, self._expiry):
            end.destroy_when_not_in_use()


def _taken(service: Service, cls: Any) -> tuple[rmw_request_id_t | None, Any]:
    request, info = service.service_take_request(cls)
    return (None, None) if info is None else (info.request_id, request)


def _answer(service: Service, header: rmw_request_id_t, response: Any) -> None:
    service.service_send_response(response, header)


def _nanoseconds(stamp: Any) -> int:
    return int(stamp.sec) * SECOND + int(stamp.nanosec)


def _describe(info: Any, goal: ActionGoalHandle) -> None:
    """Fill in an action_msgs/msg/GoalInfo."""
    import numpy as np  # noqa: PLC0415

    info.goal_id.uuid = np.frombuffer(goal.id, dtype=np.uint8).copy()
    info.stamp.sec, info.stamp.nanosec = divmod(goal.stamp, SECOND)
