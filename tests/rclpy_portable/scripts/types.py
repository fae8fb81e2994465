"""Ends of one name and two types, in one program; print what is refused."""

import rclpy
from std_msgs.msg import Bool, String
from std_srvs.srv import SetBool, Trigger

rclpy.init(args=["--ros-args", "--disable-rosout-logs"])
node = rclpy.create_node("types")
other = rclpy.create_node("other", namespace="/n")


def tried(name, make, *arguments):
    try:
        print(name, "made", type(make(*arguments)).__name__)
    except Exception as error:
        said = str(error).partition(", at /")[0].lower()
        # rmw_fastrtps loses what it has to say of a subscription: "invalid allocator"
        print(name, type(error).__name__, said if "subscription" not in name else "")


def ignore(*_):
    """Take whatever comes."""


for order in ("first a publisher", "first a subscription"):
    topic = f"/{order.split()[-1]}"
    print(order)
    if order.endswith("publisher"):
        tried("  publisher", node.create_publisher, String, topic, 1)
    else:
        tried("  subscription", node.create_subscription, String, topic, ignore, 1)
    tried("  publisher", other.create_publisher, Bool, topic, 1)
    tried("  subscription", other.create_subscription, Bool, topic, ignore, 1)
    tried("  publisher", other.create_publisher, String, topic, 1)
    tried("  subscription", node.create_subscription, String, topic, ignore, 1)

for order in ("server", "client"):
    service = f"/by_{order}"
    print("first a", order)
    if order == "server":
        tried("  server", node.create_service, Trigger, service, ignore)
    else:
        tried("  client", node.create_client, Trigger, service)
    tried("  server", other.create_service, SetBool, service, ignore)
    tried("  client", other.create_client, SetBool, service)
    tried("  server", other.create_service, Trigger, service, ignore)
    tried("  client", node.create_client, Trigger, service)

last = node.create_publisher(String, "/free_again", 1)
node.destroy_publisher(last)
tried("once it is gone", node.create_publisher, Bool, "/free_again", 1)
rclpy.shutdown()
