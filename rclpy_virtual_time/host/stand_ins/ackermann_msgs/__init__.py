"""A stand-in for the package ackermann_msgs, which has no wheel."""
