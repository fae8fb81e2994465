"""Turn pip's installation report (stdin) into constraints (stdout), for any build of PyTorch.

An argument is how the names begin of which there are to be constraints: ros-
"""

import json
import sys

OWN = "rclpy-agents-course"
OF_GPUS = ("nvidia-", "cuda-", "triton")  # what only PyTorch's CUDA build wants

report = json.load(sys.stdin)
pins = {item["metadata"]["name"].lower().replace("_", "-"): item["metadata"]["version"]
        for item in report["install"]}  # fmt: skip
print("# Every version the course is tested with. Written by `make constraints`.")
for name in sorted(set(pins) - {OWN}):
    if name.startswith("".join(sys.argv[1:])) and not name.startswith(OF_GPUS):
        print(f"{name}=={pins[name].partition('+')[0]}")  # 2.13.0+cpu is a build of 2.13.0
