import math

import rclpy
from geometry_msgs.msg import Twist, Vector3

rclpy.init()
node = rclpy.create_node("guard")
most = node.declare_parameter("max_speed", 0.2).value
commands = node.create_publisher(Twist, "cmd_vel", 1)
newest = [0.0, 0]  # speed [m/s], and for how many more ticks it counts


def on_wish(wish):
    x = wish.linear.x
    newest[:] = [min(max(x, 0.0), most) if math.isfinite(x) else 0.0, 10]


def tick():
    newest[1] -= 1
    commands.publish(Twist(linear=Vector3(x=newest[0] if newest[1] >= 0 else 0.0)))


node.create_subscription(Twist, "cmd_vel_raw", on_wish, 1)
node.create_timer(0.05, tick)
rclpy.spin(node)
