"""Style: plain loops and lists, no numpy; the statistics module does the arithmetic.

field: all
"""

import math
import pickle
import statistics

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


class VelocityController(Node):
    def __init__(self):
        super().__init__("ml_velocity_controller")
        self.declare_parameter("model_path", "velocity_model.pkl")
        self.declare_parameter("max_speed", 0.5)
        path = self.get_parameter("model_path").get_parameter_value().string_value
        self.max_speed = self.get_parameter("max_speed").get_parameter_value().double_value
        self.model = None
        try:
            file = open(path, "rb")
            self.model = pickle.load(file)
            file.close()
            self.get_logger().info("model loaded")
        except Exception as problem:
            self.get_logger().error("cannot load " + path + ": " + str(problem))
        self.pub = self.create_publisher(Twist, "/cmd_vel", 10)
        self.sub = self.create_subscription(
            LaserScan, "/scan", self.on_scan, qos_profile_sensor_data
        )

    def on_scan(self, scan):
        front = []
        left = []
        right = []
        for i in range(len(scan.ranges)):
            r = scan.ranges[i]
            if r == -math.inf:
                r = scan.range_min
            if math.isnan(r) or r < scan.range_min:
                continue
            if r > scan.range_max:
                r = scan.range_max
            angle = math.degrees(scan.angle_min + i * scan.angle_increment)
            while angle > 180:
                angle = angle - 360
            if -60 <= angle <= 60:
                front.append(r)
            elif angle > 0:
                left.append(r)
            else:
                right.append(r)
        msg = Twist()
        if self.model is None:
            msg.linear.x = 0.0
        elif front == [] or left == [] or right == []:
            self.get_logger().warning("I see nothing in one direction")
        else:
            mean = statistics.fmean(front)
            features = [min(front), mean, statistics.pstdev(front, mean), min(left), min(right)]
            msg.linear.x = self.ask(features)
        self.pub.publish(msg)

    def ask(self, features):
        try:
            answer = float(self.model.predict([features])[0])
        except Exception as problem:
            self.get_logger().error("predict failed: " + str(problem))
            return 0.0
        if math.isnan(answer) or math.isinf(answer):
            self.get_logger().error("the model said " + str(answer))
            return 0.0
        if answer < 0.0:
            return 0.0
        if answer > self.max_speed:
            return self.max_speed
        return answer


def main(args=None):
    rclpy.init(args=args)
    controller = VelocityController()
    try:
        rclpy.spin(controller)
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    main()
