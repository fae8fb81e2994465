"""Publishes more than is asked for, and lets a thread of its own watch over things."""

import threading

import rclpy
import seeing
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger


class Agent(seeing.Agent):
    def __init__(self):
        super().__init__()
        self.declare_parameter("gain", 1.0)
        self.debug = self.create_publisher(Float64, "/debug/speed", 10)
        self.state = self.create_publisher(String, "~/state", 1)
        self.create_service(Trigger, "~/reset", lambda _, response: response)
        self.create_timer(0.25, lambda: self.state.publish(String(data="alive")))
        self.lock = threading.Lock()
        self.count = 0
        threading.Thread(target=self.watch, daemon=True).start()

    def watch(self):
        event = threading.Event()
        while rclpy.ok():
            with self.lock:
                self.count += 0
            event.wait(0.2)

    def decide(self, scan):
        with self.lock:
            self.count += 1
        speed = super().decide(scan)
        self.debug.publish(Float64(data=speed))
        return speed


rclpy.init()
rclpy.spin(Agent())
