"""Ask about names and QoS; print the answers."""

import itertools

from rclpy.duration import Duration
from rclpy.impl.implementation_singleton import rclpy_implementation as native
from rclpy.qos import (
    DurabilityPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
)

WORDS = [
    "", "a", "a/b", "/a/b", "~", "~/a", "a~", "~a", "a//b", "a/", "/", "1a", "a/1b", "a b",
    "{node}/x", "{ns}", "{x", "x}", "{a b}", "{1}", "{nope}/x", "a-b", "/a?", "_x", "x" * 250,
    "/" + "y" * 248,
]  # fmt: skip
CHECKS = ("topic_name", "full_topic_name", "namespace", "node_name")

for word, check in itertools.product(WORDS, CHECKS):
    print(check, word[:20], getattr(native, f"rclpy_get_validation_error_for_{check}")(word))
for word in WORDS:
    for namespace in ("/", "/n/m"):
        try:
            print("expand", word[:20], native.rclpy_expand_topic_name(word, "me", namespace))
        except Exception as error:
            print("expand", word[:20], type(error).__name__)

CHOICES = [
    {"reliability": r, "durability": d, "liveliness": s, "deadline": Duration(nanoseconds=t)}
    for r in (ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT)
    for d in (DurabilityPolicy.VOLATILE, DurabilityPolicy.TRANSIENT_LOCAL)
    for s in (LivelinessPolicy.AUTOMATIC, LivelinessPolicy.MANUAL_BY_TOPIC)
    for t in (0, 10, 20)
]
for a, b in itertools.product(CHOICES, CHOICES):
    verdict, reason = qos_check_compatible(QoSProfile(depth=1, **a), QoSProfile(depth=1, **b))
    print(int(verdict), reason)
