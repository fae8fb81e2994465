"""A stand-in for the messages of the package tf2_msgs, which has no wheel."""
