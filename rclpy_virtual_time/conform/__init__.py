"""Is virtual time like time? The tests of rclpy and of CPython, run in plain Python and in a host.

What is tested is not ours, and none of it is stored here: rclpy's tests come from a checkout that
is given by its path, CPython's from the interpreter. What differs has to be in the reviewed list
(`reviewed.toml`), with the reason why it is meant.
"""
