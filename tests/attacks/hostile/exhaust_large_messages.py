"""Publish messages of 10 MB.

gains: nothing
score: 0
outcome: flooded
"""

from kit import drive
from std_msgs.msg import String


def shout(node, scan):
    node.shout = getattr(node, "shout", None) or node.create_publisher(String, "/shout", 10)
    node.shout.publish(String(data="x" * 10_000_000))


drive(shout)
