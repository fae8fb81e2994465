"""Style: a careful beginner, plain loops and ifs, lists and pop(0), everything in one callback.

field: field_lds01, field_wide_lidar, field_mirrored_world, field_speckle, field_lost_scans
"""

import math

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64


class MyAgent(Node):
    def __init__(self):
        super().__init__("trend_agent")
        self.pub = self.create_publisher(Twist, "/cmd_vel", 10)
        self.speed_pub = self.create_publisher(Float64, "/closing_speed", 10)
        self.sub = self.create_subscription(LaserScan, "/scan", self.callback, 10)
        self.times = []
        self.distances = []
        self.old_sec = None
        self.old_nanosec = None

    def callback(self, msg):
        # 1. what is ahead?
        smallest = None
        angle = msg.angle_min
        for r in msg.ranges:
            a = angle
            while a > math.pi:
                a = a - 2 * math.pi
            while a < -math.pi:
                a = a + 2 * math.pi
            angle = angle + msg.angle_increment
            if a < -math.pi / 2 or a > math.pi / 2:
                continue
            if math.isnan(r):
                continue
            if r == float("-inf"):
                r = 0.0
            elif r != float("inf") and (r < msg.range_min or r > msg.range_max):
                continue
            if smallest is None or r < smallest:
                smallest = r

        # 2. did the clock jump?
        sec = msg.header.stamp.sec
        nanosec = msg.header.stamp.nanosec
        if self.old_sec is not None:
            step = (sec - self.old_sec) + (nanosec - self.old_nanosec) / 1e9
            if step < 0 or step > 1.0:
                self.times = []
                self.distances = []
        self.old_sec = sec
        self.old_nanosec = nanosec

        # 3. remember
        closing = None
        if smallest is not None and smallest != float("inf"):
            self.times.append([sec, nanosec])
            self.distances.append(smallest)
            if len(self.times) > 10:
                self.times.pop(0)
                self.distances.pop(0)
            if len(self.times) == 10:
                closing = self.fit()
                m = Float64()
                m.data = closing
                self.speed_pub.publish(m)

        # 4. drive
        t = Twist()
        t.linear.x = 0.3
        if smallest is None:
            t.linear.x = 0.0
        elif smallest < 0.5:
            t.linear.x = 0.0
        elif closing is not None:
            if closing > 0 and smallest / closing < 2.0:
                t.linear.x = 0.0
        self.pub.publish(t)
        self.get_logger().info("distance " + str(smallest) + " closing " + str(closing))

    def fit(self):
        # slope = (n*sum(xy) - sum(x)*sum(y)) / (n*sum(xx) - sum(x)^2), x from the first reading
        n = 10
        sx = sy = sxx = sxy = 0.0
        for i in range(n):
            x = (self.times[i][0] - self.times[0][0]) + (self.times[i][1] - self.times[0][1]) / 1e9
            y = self.distances[i]
            sx = sx + x
            sy = sy + y
            sxx = sxx + x * x
            sxy = sxy + x * y
        spread = n * sxx - sx * sx
        if spread == 0:  # all stamps are the same
            return 0.0
        return -(n * sxy - sx * sy) / spread


def main(args=None):
    rclpy.init(args=args)
    node = MyAgent()
    rclpy.spin(node)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
