"""The messages of example_interfaces: those of std_msgs that are a value alone."""

from rclpy_virtual_time.host.interfaces import define

VALUES = {"Bool": "bool", "Float32": "float32", "Float64": "float64", "Int8": "int8",
          "Int16": "int16", "Int32": "int32", "Int64": "int64", "String": "string",
          "UInt8": "uint8", "UInt16": "uint16", "UInt32": "uint32", "UInt64": "uint64"}  # fmt: skip
globals().update(
    define("example_interfaces", {name: f"{kind} data" for name, kind in VALUES.items()})
)
