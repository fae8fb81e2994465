"""The kernel in a process of its own, without rclpy: it replaces locks and clocks for good."""

import json
import subprocess
import sys
import textwrap

PREAMBLE = """
import json, queue, sys, threading, time
from rclpy_virtual_time.host.virtual import kernel as k, threads

class Alone(k.World):
    '''A world with an event every 10 ms and nothing in it.'''
    def exchange(self):
        self.until += 10_000_000
        if self.until > 10**10:
            raise SystemExit('time ran away')

kernel = k.Kernel(Alone())
threads.install(kernel, 1_700_000_000 * 10**9)
said = []
def say(*words): said.append([kernel.now / 1e9, *words])
"""


def run(source: str) -> list[list[object]]:
    """Run some lines; return what they said, with the time rounded to 10 µs (ten readings)."""
    program = PREAMBLE + textwrap.dedent(source) + "\nprint(json.dumps(said))"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 0, done.stderr
    return [[round(now, 5), *words] for now, *words in json.loads(done.stdout)]
