"""The clients of the server next door, without a class as well."""

import itertools

import rclpy
from std_msgs.msg import String, UInt32
from std_srvs.srv import Trigger


def main(args=None):
    rclpy.init(args=args)
    node = rclpy.create_node("detection_client")
    role = node.declare_parameter("role", "navigation").value
    client = node.create_client(Trigger, "/detect")
    heartbeat = node.create_publisher(UInt32, f"/{role}/heartbeat", 10)
    detection = node.create_publisher(String, f"/{role}/detection", 10)
    count = itertools.count(1)
    owed = []

    def beat():
        heartbeat.publish(UInt32(data=next(count)))

    def give_up(future):
        def late():
            node.destroy_timer(timer)
            if future in owed:
                owed.remove(future)
                client.remove_pending_request(future)
                node.get_logger().warning("no answer within a second")

        timer = node.create_timer(1.05, late)

    def ask():
        if owed or not client.service_is_ready():
            return
        future = client.call_async(Trigger.Request())
        owed.append(future)
        future.add_done_callback(hear)
        give_up(future)

    def hear(future):
        if future in owed:
            owed.remove(future)
        if future.result().success:
            detection.publish(String(data=future.result().message))

    node.create_timer(0.1, beat)
    node.create_timer(0.5, ask)
    rclpy.spin(node)


if __name__ == "__main__":
    main()
