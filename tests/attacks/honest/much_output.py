"""Logs every beam; has a logger of its own, to a file and in colour; warnings and progress bars."""

import logging
import sys
import warnings
from pathlib import Path

import rclpy
import seeing

warnings.simplefilter("always")
logging.basicConfig(level=logging.DEBUG, stream=sys.stderr)
log = logging.getLogger("agent")
log.addHandler(logging.FileHandler(Path(__file__).with_suffix(".log"), "w", "utf-8"))
log.addHandler(logging.StreamHandler(sys.stdout))
log.handlers[1].setFormatter(logging.Formatter("\x1b[32m%(message)s\x1b[0m"))


class Noisy(seeing.Agent):
    def decide(self, scan):
        sys.stderr.write("\rprogress 12 %\rprogress 50 %")
        warnings.warn("this is old", DeprecationWarning, stacklevel=1)
        self.get_logger().info(f"ranges: {list(scan.ranges)}")
        print(*scan.ranges, sep="\n")
        speed = super().decide(scan)
        log.info("Geschwindigkeit %.2f m/s: läuft ✓", speed)
        return speed


rclpy.init()
rclpy.spin(Noisy())
