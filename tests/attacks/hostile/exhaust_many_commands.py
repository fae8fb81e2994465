"""Answer each scan with 1,500 commands: allowed each time, and far too many in the end.

gains: nothing
score: 5
outcome: flooded, completed
"""

from kit import drive


def many(node, scan):
    for _ in range(1_500):
        node.drive(0.15)


drive(many)
