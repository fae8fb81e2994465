"""Ask about names, arguments and QoS; print the answers."""

import itertools

from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.impl.implementation_singleton import rclpy_implementation as native
from rclpy.node import Node
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

COMMANDS = [
    ["-p", "a:=1", "-p", "b:=0x1f", "-p", "c:=017", "-p", "d:=1.5e3", "-p", "e:=yes",
     "-p", "f:='1'"],
    ["-p", "a:=[1, 2]", "-p", "b:=[1.0, .5]", "-p", "c:=[x, y]", "-p", "d:=[true, off]"],
    ["-p", "n:=.nan", "-p", "i:=-.inf", "-p", "s:=two words", "-p", "t:=\"q\"", "-p", "z:=1_000"],
    ["-p", "talker:x:=1", "-p", "me:y:=2", "-p", "x.y:=3"],
    ["-r", "/a:=/b", "-r", "me:c:=d", "-r", "other:e:=f", "-r", "__ns:=/new", "-r", "__node:=you"],
    ["--log-level", "debug"], ["--disable-rosout-logs"], ["--nope"], ["-p", "x"], ["-r", "x"],
    ["-p", "x:=[1, 2.0]"], ["--log-level", "loud"], ["--params-file", "missing.yaml"],
]  # fmt: skip
for command in COMMANDS:
    context = Context()
    try:
        context.init(args=["--ros-args", *command])
    except Exception as error:
        print(command, type(error).__name__)
        continue
    node = Node("me", context=context, allow_undeclared_parameters=True,
                automatically_declare_parameters_from_overrides=True)  # fmt: skip
    found = {name: p.value for name, p in node._parameters.items() if len(name) < 4}
    print(command, node.get_fully_qualified_name(), found)
    print([node.resolve_topic_name(word) for word in ("a", "c", "e", "~/x", "/a")])
    node.destroy_node()
    context.shutdown()

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
