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


TOPICS = {"publisher": (1,), "subscription": (ignore, 1)}  # an end: what is said of it besides
SERVICES = {"service": (ignore,), "client": ()}
for ends, right, wrong in ((TOPICS, String, Bool), (SERVICES, Trigger, SetBool)):
    (one, _), (another, _) = ends.items()
    for first in ends:
        print("first a", first)
        order = ((node, first, right), (other, one, wrong), (other, another, wrong),
                 (other, one, right), (node, another, right))  # fmt: skip
        for owner, end, type_ in order:
            tried(f"  {end}", getattr(owner, f"create_{end}"), type_, f"/by_{first}", *ends[end])

last = node.create_publisher(String, "/free_again", 1)
node.destroy_publisher(last)
tried("once it is gone", node.create_publisher, Bool, "/free_again", 1)
rclpy.shutdown()
