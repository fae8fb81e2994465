"""Answer each scan with a storm of commands.

gains: nothing
score: 0
outcome: flooded
"""

from kit import drive


def storm(node, scan):
    for _ in range(5_000):
        node.drive(0.15)


drive(storm)
