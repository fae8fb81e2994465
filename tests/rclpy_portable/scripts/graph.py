"""Nodes that find each other, lose each other, and hear of it; print what they see."""

import time

import rclpy
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Bool, String
from std_srvs.srv import Trigger

rclpy.init(args=["--ros-args", "--disable-rosout-logs"])
a, b = rclpy.create_node("a"), rclpy.create_node("b", namespace="/n")
executor = rclpy.executors.SingleThreadedExecutor()
executor.add_node(a)
executor.add_node(b)
said = []


def spin(until=lambda: False, seconds=0.3):
    end = time.monotonic() + (5 if until() is False and seconds is None else seconds)
    while time.monotonic() < end and not until():
        executor.spin_once(timeout_sec=0.02)


def note(name):
    return lambda event: said.append((name, {
        key: int(getattr(event, key)) for key in ("total_count", "total_count_change",
        "current_count", "current_count_change", "last_policy_kind") if hasattr(event, key)
    }))  # fmt: skip


latched = QoSProfile(depth=2, durability=DurabilityPolicy.TRANSIENT_LOCAL)
publisher = a.create_publisher(String, "t", latched, event_callbacks=PublisherEventCallbacks(
    matched=note("pub matched"), incompatible_qos=note("pub incompatible")))  # fmt: skip
for text in "xyz":
    publisher.publish(String(data=text))
heard = []
late = b.create_subscription(String, "/t", lambda m: heard.append(m.data), latched,
    event_callbacks=SubscriptionEventCallbacks(matched=note("sub matched")))  # fmt: skip
spin()
print("latched", heard, sorted(said, key=str))  # whose event comes first is DDS's business
said.clear()
unreliable = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
best = a.create_publisher(String, "u", unreliable,
    event_callbacks=PublisherEventCallbacks(incompatible_qos=note("pub incompatible")))  # fmt: skip
strict = b.create_subscription(String, "/u", lambda m: heard.append(m.data), 1,
    event_callbacks=SubscriptionEventCallbacks(
        incompatible_qos=note("sub incompatible")))  # fmt: skip
best.publish(String(data="lost"))
spin()
print("incompatible", sorted(said, key=str), best.get_subscription_count())
said.clear()
b.destroy_subscription(late)
spin()
print("gone", said, publisher.get_subscription_count())
for what in (a.create_publisher, lambda t, n, q: a.create_subscription(t, n, lambda m: None, q)):
    try:
        what(Bool, "t", 1)
    except Exception as error:
        print("other type", type(error).__name__)

service = b.create_service(Trigger, "s", lambda q, r: Trigger.Response(success=True, message="ok"))
client = a.create_client(Trigger, "/n/s")
print("service", client.wait_for_service(timeout_sec=2.0))
future = client.call_async(Trigger.Request())
spin(future.done, 3)
print(future.result())
print(a.get_topic_names_and_types())
print(a.get_service_names_and_types())
print(a.get_node_names_and_namespaces(), a.count_publishers("t"), b.count_subscribers("/u"))
print(b.get_publisher_names_and_types_by_node("a", "/"))
print(a.get_service_names_and_types_by_node("b", "/n"))
print(a.get_client_names_and_types_by_node("a", "/"))
try:
    a.get_client_names_and_types_by_node("nobody", "/")
except Exception as error:
    print(type(error).__name__)
info = a.get_publishers_info_by_topic("t")[0]
print(info.node_name, info.topic_type, info.qos_profile, info.endpoint_type)

b.declare_parameter("speed", 1.5)
remote = AsyncParameterClient(a, "/n/b")
print("parameters", remote.wait_for_services(timeout_sec=2.0))
for future in (remote.list_parameters(), remote.get_parameters(["speed", "nope"]),
               remote.set_parameters([Parameter("speed", value=2.5)]),
               remote.describe_parameters(["speed"])):  # fmt: skip
    spin(future.done, 3)
    print(future.result())
print(b.get_parameter("speed").value)
print(a.resolve_topic_name("~/x"), a.resolve_service_name("y"), b.get_fully_qualified_name())
timer = a.create_timer(0.01, lambda: said.append("tick"))
spin(lambda: len(said) >= 3, 3)
timer.cancel()
print("ticks", len(said) >= 3, timer.is_canceled(), timer.time_until_next_call())
rclpy.shutdown()
print(rclpy.ok())
