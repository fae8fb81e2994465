"""Names of nodes and topics as long as ROS lets them be, and many.

gains: nothing
score: 20
outcome: any
"""

from kit import attempt, drive
from std_msgs.msg import Bool


def name(node, scan):
    if node.heard == 1:
        for number in range(40):
            with attempt():
                node.create_publisher(Bool, f"/{'a' * 230}_{number}", 1)
    raise RuntimeError("x" * 100_000)


with attempt():
    drive(name, name="n" * 200)
drive(name, name="n")
