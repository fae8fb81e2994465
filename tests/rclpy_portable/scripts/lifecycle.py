"""A managed node goes through its states, by itself and by its services; print them."""

import rclpy
from lifecycle_msgs.msg import Transition, TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetAvailableStates, GetAvailableTransitions, GetState
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn

rclpy.init(args=["--ros-args", "--disable-rosout-logs"])


class Managed(LifecycleNode):
    """Fails to activate once."""

    failures = 1

    def on_configure(self, state):
        """Say from where."""
        print("configure from", state.label)
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state):
        """Fail once."""
        self.failures -= 1
        if self.failures == 0:
            return TransitionCallbackReturn.FAILURE
        return super().on_activate(state)

    def on_error(self, state):
        """Recover."""
        print("error from", state.label)
        return TransitionCallbackReturn.SUCCESS


node, other = Managed("m"), rclpy.create_node("o")
executor = rclpy.executors.SingleThreadedExecutor()
executor.add_node(node)
executor.add_node(other)
events = []
other.create_subscription(
    TransitionEvent, "/m/transition_event",
    lambda e: events.append((e.transition.id, e.start_state.label, e.goal_state.label)), 20,
)  # fmt: skip


def ask(kind, name, **fields):
    client = other.create_client(kind, f"/m/{name}")
    client.wait_for_service(timeout_sec=3)
    future = client.call_async(kind.Request(**fields))
    executor.spin_until_future_complete(future, timeout_sec=3)
    return future.result()


machine = node._state_machine
print(machine.current_state, machine.available_states)
print(machine.transition_graph)
print(node.trigger_configure(), machine.current_state, machine.available_transitions)
print(node.trigger_activate(), machine.current_state)
print(ask(GetState, "get_state"))
for number in (Transition.TRANSITION_ACTIVATE, Transition.TRANSITION_CONFIGURE):
    try:
        print(ask(ChangeState, "change_state", transition=Transition(id=number)))
    except Exception as error:
        print(type(error).__name__)
print(len(ask(GetAvailableStates, "get_available_states").available_states))
print(len(ask(GetAvailableTransitions, "get_available_transitions").available_transitions))
print(len(ask(GetAvailableTransitions, "get_transition_graph").available_transitions))
print(node.trigger_deactivate(), node.trigger_cleanup(), node.trigger_shutdown())
print(machine.current_state)
for _ in range(500):  # a busy machine takes its time
    if events and events[-1][-1] == "finalized":
        break
    executor.spin_once(timeout_sec=0.02)
print(events)
rclpy.shutdown()
