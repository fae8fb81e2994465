"""The numbers of slow_model's contract."""

from __future__ import annotations

from grader.checks.braking import braking, model_says_go
from grader.checks.contract import Contract, Survived

LONGEST_GAP = 0.075  # [s] between two commands
LEAST_COMMANDS = 19.0  # per second, on average
MOST_COMMANDS = 21.0  # per second, on average
LEAST_RATE = 3.0  # [Hz] of inference
LEAST_RATE_5_HZ = 2.4  # [Hz] with a lidar of 5 Hz
AGE_P95 = 0.58  # [s] of the scan behind a command
AGE_P95_5_HZ = 0.6  # [s] with a lidar of 5 Hz
MAX_AGE = 0.6  # [s] of the scan behind a command; an older one means 0.0 ...
LATEST_STOP = 0.65  # [s] ... by the next tick

CONTRACT = Contract(
    period=0.05,
    free=model_says_go,
    nodes=(braking("slow", seconds=0.2),),
    delayed_in=("slow_wall",),
    survives=Survived(sensors=300, commands=300),
)
