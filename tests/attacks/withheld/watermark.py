"""Says its watermark through every channel that a node has; `ENDS` says how it goes on."""

import os
import sys
import threading
import warnings

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String

MARK, NUMBER, AFTER, ENDS = "MARK", 0.125, 3, "raises"  # the test writes others


class Marked(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, 10)
        self.declare_parameter(MARK, MARK)
        self.other = rclpy.create_node(MARK)
        self.string = self.create_publisher(String, f"/{MARK}", 10)
        self.scan = self.create_publisher(LaserScan, f"/{MARK}/scan", 10)
        self.diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        setattr(self, MARK, [])
        threading.Thread(target=threading.Event().wait, name=MARK, daemon=True).start()
        os.environ[MARK] = MARK
        self.heard = 0

    def scan_callback(self, scan):
        self.heard += 1
        getattr(self, MARK).extend(bytearray(1000) for _ in range(50))
        self.say()
        twist = Twist()
        twist.linear.x = NUMBER
        self.cmd_vel.publish(twist)
        if self.heard < AFTER:
            return
        if ENDS == "exits":
            sys.exit(MARK)
        if ENDS == "hangs":
            eval(compile("while True: pass", f"{MARK}.py", "exec"))
        if ENDS == "raises":
            raise type(MARK, (ValueError,), {})(MARK)
        if ENDS == "in a function":
            seen = MARK  # noqa: F841
            code = f"def {MARK}(seen):\n    raise ValueError(seen)\n{MARK}('{MARK}')"
            exec(compile("\n" * AFTER + code, f"{MARK}.py", "exec"))

    def say(self):
        self.get_logger().info(MARK)
        self.get_logger().warning(MARK)
        self.get_logger().error(MARK)
        self.get_logger().fatal(MARK)
        rclpy.logging.get_logger(MARK).error(MARK)
        print(MARK, flush=True)
        print(MARK, file=sys.stderr, flush=True)
        warnings.warn(MARK, stacklevel=1)
        with open(f"{MARK}.txt", "w") as file:
            file.write(MARK)
        self.string.publish(String(data=MARK))
        scan = LaserScan()
        scan.header.frame_id = MARK
        self.scan.publish(scan)
        values = [KeyValue(key=MARK, value=MARK)]
        status = DiagnosticStatus(name=MARK, message=MARK, hardware_id=MARK, values=values)
        self.diagnostics.publish(DiagnosticArray(status=[status]))


rclpy.init()
rclpy.spin(Marked())
