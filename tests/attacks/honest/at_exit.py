"""Prints its statistics at exit, and handles signals on its own."""

import atexit
import collections
import signal
import sys

import rclpy
import seeing
from rclpy.signals import SignalHandlerOptions

speeds = collections.Counter()
atexit.register(lambda: print("how often which speed:", dict(speeds)))
signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))


class Agent(seeing.Agent):
    def decide(self, scan):
        speed = super().decide(scan)
        speeds[speed] += 1
        return speed


if __name__ == "__main__":
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = Agent()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        print("bye")
    finally:
        node.destroy_node()
