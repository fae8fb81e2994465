"""One run of the mock robot: from the command line's options to a clean shutdown."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from sim.errors import InputError
from sim.live.extras import open_extras
from sim.live.memory import settling
from sim.live.node import MockRobot
from sim.live.options import Options
from sim.live.parameters import Settings, declare
from sim.live.robot import IDLE_TICK_NS, LiveRobot, clock_tick, rehearse
from sim.live.timeline import Timeline

NAME = "mock_robot"


def run(options: Options, ros_args: list[str], stopped: Callable[[], bool]) -> None:
    """Run a robot until `stopped` says so, or until the scenario is over if it ends with it.

    Raises InputError: an option, a parameter or a ROS argument is wrong.
    """
    with ExitStack() as life:
        context = life.enter_context(_participant(ros_args))
        node = Node(NAME, context=context)
        life.callback(node.destroy_node)
        settings = declare(node, options)
        with settling():
            live_robot = _prepared(settings)
        extras = open_extras(options, NAME, life)
        stamped_node = life.enter_context(_node_for_stamped(node))
        robot = MockRobot(node, stamped_node, live_robot, settings, extras)
        executor = SingleThreadedExecutor(context=context)
        life.callback(executor.shutdown)
        executor.add_node(node)
        executor.add_node(stamped_node)
        robot.spin(executor, stopped)
        if extras.recorder:
            node.get_logger().info(
                f"{extras.recorder.count} messages recorded in {extras.recorder.folder}"
            )


@contextmanager
def _participant(ros_args: list[str]) -> Iterator[Any]:
    """Join ROS; signals are not rclpy's, so that a bag is closed before the process ends."""
    context = Context()
    try:
        rclpy.init(args=ros_args, context=context, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # RCLError and its kin are classes of the extension module
        raise InputError(f"rclpy does not start: {error}") from None
    try:
        yield context
    finally:
        context.try_shutdown()


@contextmanager
def _node_for_stamped(node: Any) -> Iterator[Any]:
    with _participant([]) as context:
        stamped_node = Node(
            f"{node.get_name()}_stamped",
            namespace=node.get_namespace(),
            context=context,
            use_global_arguments=False,
            start_parameter_services=False,
            enable_rosout=False,
        )
        try:
            yield stamped_node
        finally:
            stamped_node.destroy_node()


def _prepared(settings: Settings) -> LiveRobot:
    """Return the robot that the parameters ask for, at rest."""
    rehearse(settings.scenario)
    tick = clock_tick(settings.rate) if settings.clock else IDLE_TICK_NS
    timeline = Timeline(rate=settings.rate, simulated=settings.clock)
    return LiveRobot(settings.scenario, timeline, tick)
