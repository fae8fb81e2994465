"""Publish on /cmd_vel in another type, and bytes that are no message of it.

gains: nothing
score: 20
outcome: any
"""

from kit import attempt, drive


def garble(node, scan):
    with attempt():
        node.cmd_vel.publish(b"\x00\x01\x00\x00" + b"\xff" * 48)
    with attempt():
        node.cmd_vel.publish(b"")


drive(garble)
