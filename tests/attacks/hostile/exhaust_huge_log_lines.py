"""Log lines of a megabyte, through ROS's own logger.

gains: nothing
score: 20
outcome: completed
"""

from kit import drive

LINE = "x" * 1_000_000


def talk(node, scan):
    if node.heard < 4:
        node.get_logger().error(LINE)


drive(talk)
