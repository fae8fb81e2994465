"""The action of example_interfaces."""

from rclpy_virtual_time.host.interfaces import define

FIBONACCI = "int32 order\n---\nint32[] sequence\n---\nint32[] sequence"
globals().update(define("example_interfaces", {"Fibonacci": FIBONACCI}, "action"))
