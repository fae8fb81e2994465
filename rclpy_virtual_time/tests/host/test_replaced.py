"""The table of what hosts replace in rclpy is complete, and nothing stands in it in vain."""

import re
import subprocess
import sys
from pathlib import Path

DOCUMENT = Path(__file__).parents[2] / "docs" / "virtual-time.md"
NAME = re.compile(r"`(rclpy(?:\.\w+)+)`")
LISTING = """
import sys, types
from rclpy_virtual_time.host import asked, forkserver, frames
from rclpy_virtual_time.host.virtual import kernel as kernels, threads
kernel = kernels.Kernel(kernels.World())
if {virtual}:
    threads.install(kernel, 10**18)
import rclpy.action, rclpy.executors, rclpy.lifecycle, rclpy.node, rclpy.wait_for_message
from rclpy_virtual_time.host.real_time import node as live
from rclpy_virtual_time.host.virtual import bridge, discovery, executors, programs
def names():
    found = {{}}
    for module in [m for n, m in sys.modules.items() if n.partition('.')[0] == 'rclpy']:
        for key, value in vars(module).items():
            found[module.__name__, key] = value
            if isinstance(value, type) and value.__module__.startswith('rclpy'):
                found |= {{(value.__module__, value.__name__, *k): v
                          for k, v in zip(zip(vars(value)), vars(value).values())}}
    return found
before = names()
if {virtual}:
    ends = bridge.Bridge((), discovery.Discovery(kernel, frames.Discovery(), 0))
    ends.install()
    ends.tell_rosout(executors.install(kernel, 10**18, ends).present, print)
    executors.refuse_real_time(print)
    programs.Programs(kernel, (), print)._install()
else:
    vitals = live.Vitals()
    live.EndpointWatch(vitals.on_endpoint).install()
    live._mend_executors(); live._watch_executors(vitals)
forkserver._steer_init()
asked.watch((), print, print)
after = names()
for name in after:
    if before.get(name) is not after[name]:
        print('.'.join(name))
"""


def test_the_table_of_what_is_replaced_in_rclpy_is_true() -> None:
    said = ""
    for virtual in (True, False):
        source = LISTING.format(virtual=virtual)
        done = subprocess.run(
            [sys.executable, "-c", source], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        said += done.stdout
    table = DOCUMENT.read_text("utf-8").partition("## What is replaced in rclpy")[2]
    assert set(NAME.findall(table.partition("\n## ")[0])) == set(said.split())
