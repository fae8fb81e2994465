"""A managed node's states and transitions (rcl_lifecycle/default_state_machine.c, Jazzy)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from .endpoints import Publisher
from .errors import RCLError
from .handles import Destroyable
from .qos import rmw_qos_profile_t
from .services import Service

if TYPE_CHECKING:
    from .node import Node


class State(NamedTuple):
    """A state; lifecycle_msgs/msg/State has the numbers."""

    id: int
    label: str


class Transition(NamedTuple):
    """A way from one state to another; lifecycle_msgs/msg/Transition has the numbers."""

    id: int
    label: str
    start: State
    goal: State

    def row(self) -> tuple[int, str, int, str, int, str]:
        """Return it as rclpy wants it."""
        return (self.id, self.label, *self.start, *self.goal)


UNKNOWN = State(0, "unknown")
UNCONFIGURED = State(1, "unconfigured")
INACTIVE = State(2, "inactive")
ACTIVE = State(3, "active")
FINALIZED = State(4, "finalized")
CONFIGURING = State(10, "configuring")
CLEANING_UP = State(11, "cleaningup")
SHUTTING_DOWN = State(12, "shuttingdown")
ACTIVATING = State(13, "activating")
DEACTIVATING = State(14, "deactivating")
ERROR_PROCESSING = State(15, "errorprocessing")
STATES = (
    UNKNOWN, UNCONFIGURED, INACTIVE, ACTIVE, FINALIZED, CONFIGURING, CLEANING_UP, SHUTTING_DOWN,
    ACTIVATING, DEACTIVATING, ERROR_PROCESSING,
)  # fmt: skip


def _outcomes(
    first: int, during: State, success: State, failure: State, error: State
) -> tuple[Transition, ...]:
    """Return the transitions by which a callback's result leads on."""
    return (
        Transition(first, "transition_success", during, success),
        Transition(first + 1, "transition_failure", during, failure),
        Transition(first + 2, "transition_error", during, error),
    )


TRANSITIONS = (
    Transition(1, "configure", UNCONFIGURED, CONFIGURING),
    *_outcomes(10, CONFIGURING, INACTIVE, UNCONFIGURED, ERROR_PROCESSING),
    Transition(2, "cleanup", INACTIVE, CLEANING_UP),
    *_outcomes(20, CLEANING_UP, UNCONFIGURED, INACTIVE, ERROR_PROCESSING),
    Transition(3, "activate", INACTIVE, ACTIVATING),
    *_outcomes(30, ACTIVATING, ACTIVE, INACTIVE, ERROR_PROCESSING),
    Transition(4, "deactivate", ACTIVE, DEACTIVATING),
    *_outcomes(40, DEACTIVATING, INACTIVE, ACTIVE, ERROR_PROCESSING),
    Transition(5, "shutdown", UNCONFIGURED, SHUTTING_DOWN),
    Transition(6, "shutdown", INACTIVE, SHUTTING_DOWN),
    Transition(7, "shutdown", ACTIVE, SHUTTING_DOWN),
    *_outcomes(50, SHUTTING_DOWN, FINALIZED, FINALIZED, ERROR_PROCESSING),
    *_outcomes(60, ERROR_PROCESSING, UNCONFIGURED, FINALIZED, FINALIZED),
)


def _service(name: str) -> property:
    return property(lambda machine: machine._services.get(name))


class LifecycleStateMachine(Destroyable):
    """The state of one managed node."""

    def __init__(self, node: Node, enable_com_interface: bool) -> None:
        if not isinstance(enable_com_interface, bool):
            raise TypeError(f"expected a bool, got {enable_com_interface!r}")
        self._state = UNCONFIGURED
        self._services: dict[str, Service] = {}
        self._publisher: Publisher | None = None
        if enable_com_interface:
            self._open(node)

    def _open(self, node: Node) -> None:
        from lifecycle_msgs import msg, srv  # noqa: PLC0415

        profile = rmw_qos_profile_t.predefined("services_default")
        for name, cls in (
            ("change_state", srv.ChangeState),
            ("get_state", srv.GetState),
            ("get_available_states", srv.GetAvailableStates),
            ("get_available_transitions", srv.GetAvailableTransitions),
            ("get_transition_graph", srv.GetAvailableTransitions),
        ):
            self._services[name] = Service(node, cls, f"~/{name}", profile)
        default = rmw_qos_profile_t.predefined("default")
        self._publisher = Publisher(node, msg.TransitionEvent, "~/transition_event", default)

    @property
    def initialized(self) -> bool:
        """It has a state."""
        return not self._gone

    @property
    def current_state(self) -> tuple[int, str]:
        """Number and label."""
        return self._state.id, self._state.label

    @property
    def available_states(self) -> list[tuple[int, str]]:
        """All states: number and label."""
        return [(state.id, state.label) for state in STATES]

    @property
    def available_transitions(self) -> list[tuple[int, str, int, str, int, str]]:
        """What may follow now: number and label of the transition, of its start and its goal."""
        return [transition.row() for transition in self._possible()]

    @property
    def transition_graph(self) -> list[tuple[int, str, int, str, int, str]]:
        """All transitions."""
        return [transition.row() for transition in TRANSITIONS]

    service_change_state = _service("change_state")
    service_get_state = _service("get_state")
    service_get_available_states = _service("get_available_states")
    service_get_available_transitions = _service("get_available_transitions")
    service_get_transition_graph = _service("get_transition_graph")

    def get_transition_by_label(self, label: str) -> int:
        """Return the number of a transition that may follow now."""
        for transition in self._possible():
            if transition.label == label:
                return transition.id
        raise RCLError("Failed to get transition from label")

    def trigger_transition_by_id(self, number: int, publish: bool) -> None:
        """Go to the next state."""
        self._go([t for t in self._possible() if t.id == number], publish)

    def trigger_transition_by_label(self, label: str, publish: bool) -> None:
        """Go to the next state."""
        self._go([t for t in self._possible() if t.label == label], publish)

    def _possible(self) -> list[Transition]:
        return [transition for transition in TRANSITIONS if transition.start == self._state]

    def _go(self, chosen: list[Transition], publish: bool) -> None:
        if not chosen:
            raise RCLError(
                "Failed to trigger lifecycle state machine transition: "
                f"not available from the state {self._state.label}"
            )
        self._state = chosen[0].goal
        if publish and self._publisher is not None:
            self._publisher.publish(_event(chosen[0]))

    def _destroy(self) -> None:
        for service in self._services.values():
            service.destroy_when_not_in_use()
        if self._publisher is not None:
            self._publisher.destroy_when_not_in_use()


def _event(transition: Transition) -> Any:
    from lifecycle_msgs.msg import TransitionEvent  # noqa: PLC0415

    message = TransitionEvent()  # rcl leaves the transition itself out
    message.start_state.id, message.start_state.label = transition.start
    message.goal_state.id, message.goal_state.label = transition.goal
    return message
