"""The services of example_interfaces."""

from rclpy_virtual_time.host.interfaces import define

ANSWER = "---\nbool success\nstring message"
DEFINITIONS = {
    "AddTwoInts": "int64 a\nint64 b\n---\nint64 sum",
    "SetBool": f"bool data\n{ANSWER}",
    "Trigger": ANSWER,
}
globals().update(define("example_interfaces", DEFINITIONS, "srv"))
