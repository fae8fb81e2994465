"""Turn pip's installation report (stdin) into constraints (stdout)."""

import json
import sys

OWN = "rclpy-agents-course"

report = json.load(sys.stdin)
pins = {item["metadata"]["name"].lower().replace("_", "-"): item["metadata"]["version"]
        for item in report["install"]}  # fmt: skip
print("# Every version the course is tested with. Written by `make constraints`.")
for name in sorted(set(pins) - {OWN}):
    print(f"{name}=={pins[name]}")
