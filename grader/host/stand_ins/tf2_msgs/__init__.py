"""A stand-in for the package tf2_msgs, which has no wheel: `tf2_msgs.msg.TFMessage`."""
