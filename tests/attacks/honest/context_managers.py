"""Everything in context managers, with a context of ROS's own."""

import contextlib

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from seeing import Agent


@contextlib.contextmanager
def ros():
    context = Context()
    rclpy.init(context=context)
    try:
        yield context
    finally:
        rclpy.try_shutdown(context=context)


@contextlib.contextmanager
def running(context):
    node = Agent(context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    yield executor
    node.destroy_node()


with ros() as context, running(context) as executor:
    executor.spin()
