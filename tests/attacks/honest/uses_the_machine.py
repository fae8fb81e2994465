"""Asks for CPUs, user, load and time zone; works with files, temporary ones and its own text."""

import getpass
import json
import locale
import os
import platform
import resource
import shutil
import socket
import sys
import tempfile
import time
from pathlib import Path

import rclpy
import seeing

print(platform.platform(), sys.version, os.cpu_count(), time.tzname, locale.getlocale())
print(socket.gethostname(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, os.uname())
print(os.getenv("USER"), os.path.expanduser("~"), os.getpid(), os.sched_getaffinity(0))
try:
    print(getpass.getuser())
except (KeyError, OSError):
    print("a user without a name")
here = Path(os.getcwd())
assert Path(__file__).resolve().parent == here.resolve()
assert "obstacle" in Path(__file__).read_text(encoding="utf-8")
with tempfile.TemporaryDirectory() as folder:
    target = Path(folder) / "copy.py"
    shutil.copy(__file__, target)
    shutil.copytree(folder, Path(folder).with_name("again"))
    os.chmod(target, 0o600)
    os.utime(target)
with tempfile.NamedTemporaryFile("w+", suffix=".json") as file:
    json.dump({"speeds": [0.0, 0.15, 0.5]}, file)
    file.seek(0)
    SPEEDS = json.load(file)["speeds"]
(here / "settings.json").write_text(json.dumps(SPEEDS))
os.rename("settings.json", "old.json")
os.makedirs("a/b/c")
Path("link.json").symlink_to("old.json")


class Agent(seeing.Agent):
    def __init__(self):
        super().__init__()
        self.file = open("scans.csv", "w")  # noqa: SIM115

    def decide(self, scan):
        right, speeds = super().decide(scan), json.loads(Path("link.json").read_text())
        speed = min(speeds, key=lambda each: abs(each - right))
        print(speed, file=self.file, flush=True)
        return speed


rclpy.init()
rclpy.spin(Agent())
