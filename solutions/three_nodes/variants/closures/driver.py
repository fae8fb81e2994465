import rclpy
from geometry_msgs.msg import Twist, Vector3
from std_msgs.msg import Float64

rclpy.init()
node = rclpy.create_node("driver")
fast = node.declare_parameter("cruise_speed", 0.2)
near = node.declare_parameter("stop_distance", 0.5)
wish = node.create_publisher(Twist, "cmd_vel", 1)


def on_distance(distance):
    go = distance.data >= near.value
    wish.publish(Twist(linear=Vector3(x=fast.value if go else 0.0)))


node.create_subscription(Float64, "distance", on_distance, 1)
rclpy.spin(node)
