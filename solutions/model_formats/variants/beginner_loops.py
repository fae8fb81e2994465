"""Plain loops and ifs, no numpy but for the row that a model wants.

field: all
"""

import math
import os
import pickle

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan


class PolicyController(Node):
    def __init__(self):
        super().__init__("policy_controller")
        self.declare_parameter("model_path", "velocity_model.pkl")
        self.declare_parameter("max_speed", 0.5)
        self.declare_parameter("device", "cpu")
        self.max_speed = self.get_parameter("max_speed").value
        self.device = self.get_parameter("device").value
        self.path = self.get_parameter("model_path").value
        self.format = None
        self.model = None
        try:
            self.load()
        except Exception as error:
            self.format = None
            self.get_logger().error("cannot load " + self.path + ": " + repr(error))
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.subscription = self.create_subscription(
            LaserScan, "/scan", self.scan_callback, rclpy.qos.qos_profile_sensor_data
        )

    def load(self):
        name = self.path.lower()
        if name.endswith(".pkl"):
            file = open(self.path, "rb")
            self.model = pickle.load(file)
            file.close()
            self.format = "pkl"
        elif name.endswith(".onnx"):
            import onnxruntime

            self.model = onnxruntime.InferenceSession(self.path)
            self.format = "onnx"
        elif name.endswith(".pt2"):
            import torch

            program = torch.export.load(self.path)
            if self.device == "cuda":
                if torch.cuda.is_available():
                    from torch.export.passes import move_to_device_pass

                    program = move_to_device_pass(program, "cuda")
                else:
                    self.device = "cpu"
                    self.get_logger().warning("no cuda here, so the cpu")
            self.model = program.module()
            self.format = "pt2"
        elif name.endswith(".keras"):
            os.environ["KERAS_BACKEND"] = "torch"
            import keras

            self.model = keras.models.load_model(self.path)
            self.format = "keras"
        else:
            self.get_logger().error("I do not know what " + self.path + " is")

    def ask(self, features):
        row = np.array([features], dtype="float32")
        if self.format == "pkl":
            return float(self.model.predict(row)[0])
        if self.format == "onnx":
            name = self.model.get_inputs()[0].name
            answer = self.model.run(None, {name: row})
            return float(answer[0].flatten()[0])
        if self.format == "pt2":
            import torch

            tensor = torch.tensor(row, device=self.device)
            answer = self.model(tensor)
            return answer.flatten()[0].item()
        answer = self.model.predict(row, verbose=0)
        return float(answer.flatten()[0])

    def sectors(self, scan):
        front = []
        left = []
        right = []
        angle = scan.angle_min
        for i in range(len(scan.ranges)):
            distance = scan.ranges[i]
            angle = scan.angle_min + i * scan.angle_increment
            while angle > math.pi:
                angle = angle - 2 * math.pi
            while angle < -math.pi:
                angle = angle + 2 * math.pi
            if math.isnan(distance):
                continue
            if distance == -math.inf:
                distance = scan.range_min
            if distance < scan.range_min:
                continue
            if distance > scan.range_max:
                distance = scan.range_max
            if abs(angle) <= math.radians(60):
                front.append(distance)
            elif angle > 0:
                left.append(distance)
            else:
                right.append(distance)
        return front, left, right

    def decide(self, scan):
        if self.format is None:
            return 0.0
        front, left, right = self.sectors(scan)
        if len(front) == 0 or len(left) == 0 or len(right) == 0:
            return 0.0
        mean = sum(front) / len(front)
        total = 0.0
        for distance in front:
            total = total + (distance - mean) ** 2
        deviation = math.sqrt(total / len(front))
        try:
            speed = self.ask([min(front), mean, deviation, min(left), min(right)])
        except Exception as error:
            self.get_logger().error("the model does not work: " + repr(error))
            return 0.0
        if math.isnan(speed) or math.isinf(speed):
            return 0.0
        if speed < 0:
            return 0.0
        if speed > self.max_speed:
            return self.max_speed
        return speed

    def scan_callback(self, scan):
        message = Twist()
        message.linear.x = self.decide(scan)
        self.publisher.publish(message)


def main(args=None):
    rclpy.init(args=args)
    node = PolicyController()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
