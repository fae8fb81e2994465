"""A stand-in for the package vision_msgs, which has no wheel."""
