"""Stand whenever the clearance is sampled (each 20 ms), and race in between.

gains: nothing
score: 20
outcome: completed
"""

from kit import drive


def race(node, scan):
    if node.heard > 1:
        return
    node.fast = False

    def turn():
        node.fast = not node.fast
        node.drive(0.5 if node.fast else 0.0)

    node.create_timer(0.01, turn)


drive(race)
