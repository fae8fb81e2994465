"""Timers of a clock that is set by hand; print when they are due."""

import rclpy
from rclpy.clock import ROSClock
from rclpy.clock_type import ClockType
from rclpy.time import Time

MS = 1_000_000

rclpy.init(args=["--ros-args", "--disable-rosout-logs"])
node = rclpy.create_node("timers")


def moved(clock, milliseconds):
    with clock.handle:
        time = Time(nanoseconds=1 + milliseconds * MS, clock_type=ClockType.ROS_TIME)
        clock.handle.set_ros_time_override(time._time_handle)


def look(timer, milliseconds, then=""):
    left = timer.time_until_next_call()
    print(f"  {milliseconds} ms {then}", timer.is_ready(), left and left / MS)


for period, times in (
    (500, (0, 500, 1000, 2000, 2000, 2200, 2500, 3500, 4000, 8000, 8001)),  # late by whole periods
    (300, (100, 299, 300, 601, 1000, 1799, 1800, 2401)),
    (0, (0, 0, 10)),
):
    clock = ROSClock()
    moved(clock, 0)
    with clock.handle:
        clock.handle.set_ros_time_override_is_enabled(True)
    timer = node.create_timer(period / 1000, lambda: None, clock=clock)
    print(f"every {period} ms")
    for milliseconds in times:
        moved(clock, milliseconds)
        look(timer, milliseconds)
        if timer.is_ready():
            with timer.handle:
                timer.handle.call_timer()
            look(timer, milliseconds, "called")
    timer.timer_period_ns = 700 * MS
    look(timer, milliseconds, "with another period")
    timer.reset()
    look(timer, milliseconds, "reset")
    timer.cancel()
    look(timer, milliseconds, "canceled")
rclpy.shutdown()
