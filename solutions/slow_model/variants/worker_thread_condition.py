"""Style: a mailbox with a Condition between the scan callback and a worker; no NumPy at all.

field: all
"""

import math
import pickle
import statistics
from dataclasses import dataclass
from threading import Condition, Thread

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


class Mailbox:
    """Holds one scan: a newer one throws the older one out."""

    def __init__(self) -> None:
        self._changed = Condition()
        self._scan: LaserScan | None = None

    def put(self, scan: LaserScan) -> None:
        with self._changed:
            self._scan = scan
            self._changed.notify()

    def take(self) -> LaserScan:
        with self._changed:
            self._changed.wait_for(lambda: self._scan is not None)
            scan, self._scan = self._scan, None
            return scan


@dataclass(frozen=True)
class Answer:
    speed: float
    taken_at: float


def features(scan: LaserScan) -> list[float]:
    """Raise ValueError when a sector is blind."""
    sectors: dict[str, list[float]] = {"front": [], "left": [], "right": []}
    for number, reading in enumerate(scan.ranges):
        if math.isnan(reading):
            continue
        if reading == -math.inf:
            reading = scan.range_min
        if reading < scan.range_min:
            continue
        degrees = math.degrees(scan.angle_min + number * scan.angle_increment)
        degrees = (degrees + 180) % 360 - 180
        name = "front" if -60 <= degrees <= 60 else "left" if degrees > 60 else "right"
        sectors[name].append(min(reading, scan.range_max))
    front = sectors["front"]
    mean = statistics.fmean(front)
    return [
        min(front),
        mean,
        statistics.pstdev(front, mean),
        min(sectors["left"]),
        min(sectors["right"]),
    ]


class Controller(Node):
    def __init__(self) -> None:
        super().__init__("decoupled_controller")
        path = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.max_speed = self.declare_parameter("max_speed", 0.5).value
        self.mailbox = Mailbox()
        self.answer = Answer(0.0, -math.inf)
        self.publisher = self.create_publisher(Twist, "cmd_vel", 10)
        self.create_timer(0.05, self.control_callback)
        self.create_subscription(LaserScan, "scan", self.mailbox.put, qos_profile_sensor_data)
        try:
            with open(path, "rb") as file:
                self.model = pickle.load(file)
        except Exception as error:
            self.get_logger().error(f"{path}: {error}; standing still")
        else:
            Thread(target=self.infer_for_ever, daemon=True).start()

    def infer_for_ever(self) -> None:
        while True:
            scan = self.mailbox.take()
            taken_at = scan.header.stamp.sec + scan.header.stamp.nanosec / 1e9
            try:
                speed = float(self.model.predict([features(scan)])[0])
                if not math.isfinite(speed):
                    raise ValueError(f"prediction {speed}")
                self.answer = Answer(min(max(speed, 0.0), self.max_speed), taken_at)
            except Exception as error:
                self.answer = Answer(0.0, -math.inf)
                self.get_logger().warning(f"no prediction: {error}")

    def control_callback(self) -> None:
        answer = self.answer
        now = self.get_clock().now().nanoseconds / 1e9
        twist = Twist()
        twist.linear.x = answer.speed if now - answer.taken_at <= 0.6 else 0.0
        self.publisher.publish(twist)


def main(args=None) -> None:
    rclpy.init(args=args)
    node = Controller()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
