"""Style: a second node for the lidar, spun by an executor in a second thread; a reliable reader.

It asks for reliable scans, so it makes no claim to the badge.
"""

import math
import pickle
import threading

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class Brain(Node):
    def __init__(self, path, max_speed):
        super().__init__("decoupled_controller_brain")
        self.max_speed = max_speed
        self.speed = 0.0
        self.stamp = None
        self.model = None
        try:
            file = open(path, "rb")
            self.model = pickle.load(file)
            file.close()
        except Exception as e:
            self.get_logger().error("Could not load the model: " + str(e))
        self.create_subscription(LaserScan, "/scan", self.think, 1)

    def think(self, scan):
        if self.model is None:
            return
        try:
            answer = float(self.model.predict([self.get_features(scan)])[0])
        except Exception as e:
            self.get_logger().error("The model raised: " + str(e))
            return
        if math.isnan(answer) or math.isinf(answer):
            return
        if answer < 0.0:
            answer = 0.0
        if answer > self.max_speed:
            answer = self.max_speed
        self.speed, self.stamp = answer, rclpy.time.Time.from_msg(scan.header.stamp)

    def get_features(self, scan):
        front = []
        left = []
        right = []
        for i in range(len(scan.ranges)):
            r = scan.ranges[i]
            if math.isnan(r):
                continue
            if r > scan.range_max:
                r = scan.range_max
            if r == -math.inf:
                r = scan.range_min
            if r < scan.range_min:
                continue
            angle = math.degrees(scan.angle_min + i * scan.angle_increment)
            if angle > 180:
                angle = angle - 360
            if -60 <= angle <= 60:
                front.append(r)
            elif angle > 60:
                left.append(r)
            else:
                right.append(r)
        mean = sum(front) / len(front)
        variance = 0.0
        for r in front:
            variance = variance + (r - mean) ** 2 / len(front)
        return [min(front), mean, variance**0.5, min(left), min(right)]


class Controller(Node):
    def __init__(self):
        super().__init__("decoupled_controller")
        self.declare_parameter("model_path", "velocity_model.pkl")
        self.declare_parameter("max_speed", 0.5)
        self.brain = Brain(
            self.get_parameter("model_path").value, self.get_parameter("max_speed").value
        )
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.timer = self.create_timer(0.05, self.tick)

    def tick(self):
        twist = Twist()
        speed, stamp = self.brain.speed, self.brain.stamp
        if stamp is not None:
            age = (self.get_clock().now() - stamp).nanoseconds / 1e9
            if age <= 0.6:
                twist.linear.x = speed
        self.publisher.publish(twist)


def main(args=None):
    rclpy.init(args=args)
    node = Controller()
    lidar_executor = SingleThreadedExecutor()
    lidar_executor.add_node(node.brain)
    thread = threading.Thread(target=lidar_executor.spin, daemon=True)
    thread.start()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
