"""Create publishers, each on a topic of its own, until somebody gives up.

gains: nothing
score: 20
outcome: any
"""

from kit import attempt, drive
from std_msgs.msg import Bool


def spread(node, scan):
    with attempt():
        for number in range(60):
            node.create_publisher(Bool, f"/storm_{node.heard}_{number}", 1)


drive(spread)
