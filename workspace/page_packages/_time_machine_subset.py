"""The clock that time_machine leaves to whoever asks for the real one."""

from time import time_ns as original_time_ns

__all__ = ["original_time_ns"]
