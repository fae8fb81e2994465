"""The same node in the same scenario gives the same recording, however busy the machine is."""

import contextlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest
from node_runs import PREAMBLE, short

from grader.course.exercises import SOLUTIONS
from grader.course.submission import Submission
from grader.trial.virtual_time import run_trial
from rclpy_virtual_time.link.hosts import ForkServer
from sim.scenario import Scenario
from sim.scenario_files import load_scenario

REFERENCE = SOLUTIONS / "obstacle_avoidance" / "obstacle_avoidance_agent.py"
CROWD = """
import asyncio, queue, random
from concurrent.futures import ThreadPoolExecutor
from std_srvs.srv import Trigger

class Crowd(Node):
    '''Everybody publishes what the others left behind, each in its own time.'''

    def __init__(self):
        super().__init__('crowd')
        group = ReentrantCallbackGroup()
        self.lock, self.jobs, self.pool = threading.Lock(), queue.Queue(), ThreadPoolExecutor(4)
        self.count = 0
        self.words = self.create_publisher(String, '/words', 200)
        self.create_subscription(LaserScan, '/scan', self.on_scan, 10, callback_group=group)
        self.create_service(Trigger, 'count', self.on_count, callback_group=group)
        self.client = self.create_client(Trigger, 'count', callback_group=group)
        for i in range(10):
            own = group if i % 3 else MutuallyExclusiveCallbackGroup()
            self.create_timer(0.031 + 0.006 * i, self.saying(f'timer {i}', 0.002 * i), own)
        for i in range(30):
            threading.Thread(target=self.work, args=(i,), daemon=True).start()
        threading.Thread(target=lambda: asyncio.run(self.naps()), daemon=True).start()

    def say(self, what):
        with self.lock:
            self.count += 1
            now = self.get_clock().now().nanoseconds
            self.words.publish(String(data=f'{self.count} {now} {what} {random.random()}'))

    def saying(self, what, then_sleep):
        return lambda: (self.say(what), time.sleep(then_sleep))

    async def on_scan(self, scan):
        for i in range(12):
            self.jobs.put(i)
        self.pool.submit(self.saying('pool', 0.017))
        answer = await self.client.call_async(Trigger.Request())
        self.say('answer ' + answer.message)

    def on_count(self, request, response):
        time.sleep(random.uniform(0.0, 0.02))
        response.message = str(self.count)
        return response

    def work(self, i):
        while True:
            try:
                self.say(f'worker {i} {self.jobs.get(timeout=0.04 + 0.001 * i)}')
            except queue.Empty:
                self.say(f'worker {i} waits')

    async def naps(self):
        async def nap(i):
            while True:
                await asyncio.sleep(0.02 + 0.003 * i)
                self.say(f'nap {i}')
        await asyncio.gather(*(nap(i) for i in range(5)))

rclpy.init()
executor = MultiThreadedExecutor(6)
executor.add_node(Crowd())
executor.spin()
"""


@contextlib.contextmanager
def busy_machine(busy: int) -> Iterator[None]:
    """Two processes that do nothing, as fast as they can."""
    loops = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(busy)]
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()


def assert_one(
    submission: Submission, scenario: Scenario, forkserver: ForkServer, runs: int
) -> int:
    """Run a node that often, each second time on a busy machine; return how often it published."""
    digests = set()
    for run in range(runs):
        with busy_machine(2 * (run % 2)):
            recording = run_trial(submission, scenario, forkserver)
        assert recording.outcome.completed, recording.outcome
        digests.add(recording.digest())
    assert len(digests) == 1
    return len(recording.published)


def test_the_reference_does_the_same(forkserver: ForkServer) -> None:
    scenario = msgspec.structs.replace(load_scenario("avoid_store"), duration=12.0)
    assert assert_one(Submission(REFERENCE), scenario, forkserver, 4) > 100


@pytest.mark.parametrize("runs", [2, pytest.param(20, marks=pytest.mark.long)])
def test_a_crowd_of_threads_does_the_same(
    runs: int, tmp_path: Path, forkserver: ForkServer
) -> None:
    """30 threads, two pools of them, timers, services and asyncio."""
    file = tmp_path / "crowd.py"
    file.write_text(PREAMBLE + CROWD)
    assert assert_one(Submission(file), short(1.0), forkserver, runs) > 500
