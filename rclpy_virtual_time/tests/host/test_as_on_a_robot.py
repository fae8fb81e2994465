"""What nodes do with rclpy ends in a host as it ends without one.

Each program here was also run on plain rclpy, where it says and does the same.
"""

import re

import pytest

from rclpy_virtual_time.tests.runs import RunNode, end_of, said, sent

SPINS = (
    "rclpy.spin(node)",
    "e = MultiThreadedExecutor(); e.add_node(node); e.spin()",
    "while rclpy.ok(): rclpy.spin_once(node, timeout_sec=0.3)",
)


@pytest.mark.parametrize("spin", SPINS)
def test_shutdown_in_a_callback_ends_the_spinning(run_node: RunNode, spin: str) -> None:
    recording = run_node(f"""
        class Counting(Echo):
            seen = 0
            def on_scan(self, scan):
                self.seen += 1
                super().on_scan(scan)
                if self.seen == 3: rclpy.shutdown()
        rclpy.init(); node = Counting()
        {spin}
        print('over', rclpy.ok())
    """)
    assert (end_of(recording), said(recording)) == ("returned", ["over False"])
    assert len(sent(recording, "/cmd_vel")) == 3  # the last one was published before the end


# What a program does, how it ends, and what it prints.
PROGRAMS = {
    "a thread shuts down": ("""
        rclpy.init(); node = Echo()
        threading.Timer(0.55, rclpy.shutdown).start()
        try: rclpy.spin(node)
        except rclpy.executors.ExternalShutdownException: pass
        print('over', rclpy.ok(), time.monotonic())
    """, "returned", ["over False 1000.55"]),
    "a loop publishes until the time is over": ("""
        rclpy.init(); node = Node('n'); pub = node.create_publisher(Twist, '/cmd_vel', 1)
        now = node.get_clock().now; start = now()
        while now() - start < rclpy.duration.Duration(seconds=0.5): pub.publish(Twist())
        print('done')
    """, "returned", ["done"]),
    "another node after a shutdown": ("""
        for name in 'abc':
            rclpy.init(); node = Echo(name)
            for _ in range(2): rclpy.spin_once(node)
            node.destroy_node(); rclpy.shutdown()
            print(name)
        rclpy.init(); rclpy.spin(Echo('d'))
    """, "completed", ["a", "b", "c"]),
    "a coroutine that gives way goes on at once": ("""
        import asyncio
        class Polite(Node):
            def __init__(self):
                super().__init__('polite')
                self.create_timer(1.5, self.on_timer)
            async def on_timer(self):
                before = self.get_clock().now()
                for _ in range(3): await asyncio.sleep(0)
                print((self.get_clock().now() - before).nanoseconds)
        rclpy.init(); rclpy.spin(Polite())
    """, "completed", ["1000"]),
    "a cancelled future wakes who waits for it": ("""
        from rclpy.task import Future
        async def waits(future): print(await future, future.done(), future.cancelled())
        rclpy.init(); node = Echo(); future = Future()
        rclpy.get_global_executor().create_task(waits(future))
        node.create_timer(0.5, future.cancel)
        rclpy.spin(node)
    """, "completed", ["None False True"]),
    "a coroutine that only gives way costs time": ("""
        import asyncio
        class Waiting(Node):
            def __init__(self):
                super().__init__('waiting')
                self.create_timer(1.5, self.on_timer)
            async def on_timer(self):
                end = self.get_clock().now() + rclpy.duration.Duration(seconds=0.01)
                while self.get_clock().now() < end: await asyncio.sleep(0)
                print('done')
        rclpy.init(); rclpy.spin(Waiting())
    """, "completed", ["done"]),
    "a pool that nobody shuts down": ("""
        import atexit
        from concurrent.futures import ThreadPoolExecutor
        atexit.register(print, 'exit handler')
        pool = ThreadPoolExecutor(2)
        print(pool.submit(pow, 2, 3).result())
        pool.submit(lambda: (time.sleep(0.3), print('last task')))
    """, "returned", ["8", "last task", "exit handler"]),
    "an exit handler and sys.exit": ("""
        import atexit
        atexit.register(print, 'exit handler'); sys.exit(3)
    """, "exited", ["exit handler"]),
    "an exit handler and an exception": ("""
        import atexit
        atexit.register(print, 'exit handler'); raise ValueError('no')
    """, "exception", ["exit handler"]),
    "the graph shows a robot and not the judge": ("""
        rclpy.init(); node = Echo()
        mine = node.create_publisher(String, 'my_topic', 10)
        rclpy.spin_once(node)
        print(*sorted(node.get_node_names()))
        print(mine.get_subscription_count(), node.count_subscribers('my_topic'),
              len(node.get_subscriptions_info_by_topic('my_topic')))
        print(node.publisher.get_subscription_count(), node.count_subscribers('cmd_vel'),
              *[info.node_name for info in node.get_subscriptions_info_by_topic('/cmd_vel')])
        heard = node.get_subscriber_names_and_types_by_node('mock_robot', '/')
        print(*[topic for topic, _ in heard])
        node.create_subscription(String, 'my_topic', print, 10)
        print(mine.get_subscription_count(), node.count_subscribers('my_topic'))
    """, "returned", ["echo mock_robot", "0 0 0", "1 1 mock_robot", "/cmd_vel", "1 1"]),
    "the robot's topics are there before anybody asks for them": ("""
        rclpy.init(); node = rclpy.create_node('n')
        while not node.count_publishers('/scan'): rclpy.spin_once(node, timeout_sec=0.01)
        print(dict(node.get_topic_names_and_types())['/scan'], node.count_subscribers('/cmd_vel'))
        node.create_subscription(LaserScan, '/scan', print, 10)
        node.create_publisher(Twist, '/cmd_vel', 10)
        print(node.count_publishers('/scan'), node.count_subscribers('/cmd_vel'))
    """, "returned", ["['sensor_msgs/msg/LaserScan'] 1", "1 1"]),
    "two threads can't spin one executor": ("""
        def beat(): print("beat")
        def spin(node):
            try: rclpy.spin(node)
            except ValueError as error: print(error)
        rclpy.init(); nodes = [rclpy.create_node(name) for name in 'ab']
        nodes[0].create_timer(0.4, beat)
        for node in nodes: threading.Thread(target=spin, args=(node,), daemon=True).start()
        time.sleep(1)
    """, "returned", ["generator already executing", "beat", "beat"]),
    "matched events are of others only": ("""
        from rclpy.event_handler import PublisherEventCallbacks
        def on_match(topic):
            def tell(info):
                print(topic, info.total_count, info.current_count, info.current_count_change)
            return PublisherEventCallbacks(matched=tell)
        rclpy.init(); node = rclpy.create_node('n')
        node.create_publisher(String, 'mine', 10, event_callbacks=on_match('mine'))
        node.create_publisher(Twist, 'cmd_vel', 10, event_callbacks=on_match('cmd_vel'))
        rclpy.spin_once(node, timeout_sec=0.2); rclpy.spin_once(node, timeout_sec=0.2)
        hears = node.create_subscription(String, 'mine', print, 10)
        for _ in range(4): rclpy.spin_once(node, timeout_sec=0.1)
        node.destroy_subscription(hears)
        for _ in range(4): rclpy.spin_once(node, timeout_sec=0.1)
    """, "returned", ["cmd_vel 1 1 1", "mine 1 1 1", "mine 1 0 -1"]),
    "the robot has no parameter events": ("""
        from rcl_interfaces.msg import ParameterEvent
        rclpy.init(); first = Node('first'); heard = []
        first.create_subscription(ParameterEvent, '/parameter_events', heard.append, 10)
        second = Echo('second'); second.declare_parameter('p', 1)
        for _ in range(9): rclpy.spin_once(first, timeout_sec=0.01)
        print(sorted({event.node for event in heard}))
        rclpy.spin(second)
    """, "completed", ["['/second']"]),
    "a node with a logger of its own can be destroyed": ("""
        rclpy.init(); node = Node('mocked'); node.get_logger = lambda: None
        node.destroy_node(); print('destroyed')
        rclpy.spin(Echo())
    """, "completed", ["destroyed"]),
    "a timer can be destroyed without its node": ("""
        rclpy.init(); node = Echo()
        timer = node.create_timer(0.3, lambda: (timer.cancel(), timer.destroy(), print('once')))
        node.create_timer(0.4, lambda: None); rclpy.spin(node)
    """, "completed", ["once"]),
    **{f"a {end} can't be destroyed without its node": (f"""
        rclpy.init(); node = Echo(); end = node.create_{end}(String, '/own', {more}10)
        node.create_timer(0.3, end.destroy)
        try: rclpy.spin(node)
        except rclpy.exceptions.InvalidHandle: print(time.monotonic())
    """, "returned", ["1000.3"]) for end, more in (("publisher", ""), ("subscription", "print, "))},
    "wait_for_message": ("""
        from rclpy.wait_for_message import wait_for_message
        rclpy.init(); node = Node('patient')
        print(wait_for_message(LaserScan, node, '/scan')[0], time.monotonic())
        print(wait_for_message(LaserScan, node, '/other', time_to_wait=0.5), time.monotonic())
    """, "returned", ["True 1000.013", "(False, None) 1000.513"]),
    # Of one clock, of several in turn, and between two timers that are due together
    "readings of all clocks rise": ("""
        import rclpy.clock, datetime
        from rclpy.clock import ClockType
        rclpy.init(); node = Echo()
        clocks = [node.get_clock(), *(rclpy.clock.Clock(clock_type=kind) for kind in
                  (ClockType.ROS_TIME, ClockType.SYSTEM_TIME, ClockType.STEADY_TIME))]
        read = [*(lambda c=c: c.now().nanoseconds / 1e9 for c in clocks), time.time,
                time.perf_counter, datetime.datetime.now,
                lambda: rclpy.time.Time.from_msg(clocks[0].now().to_msg()).nanoseconds]
        rows = []
        def tick():
            rows.append([clock() for clock in read])
            rows.append([clock() for clock in read])
            if len(rows) == 40:
                print(*(all(a < b for a, b in zip(c, c[1:])) for c in zip(*rows)))
                now = clocks[0].now(); start = time.perf_counter()
                for _ in range(3000): latest = clocks[0].now()
                print((latest - now).nanoseconds / 1e9, 1 / (time.perf_counter() - start) > 0)
        for _ in range(2): node.create_timer(0.1, tick)
        rclpy.spin(node)
    """, "completed", [" ".join(["True"] * 8), "0.003001 True"]),
}  # fmt: skip


@pytest.mark.parametrize("what", PROGRAMS)
def test_a_program_ends_and_prints_as_without_a_host(run_node: RunNode, what: str) -> None:
    source, kind, lines = PROGRAMS[what]
    recording = run_node(source)
    assert (end_of(recording), said(recording)) == (kind, lines)


def test_a_twist_said_right_before_shutdown_is_heard_and_none_after_it(run_node: RunNode) -> None:
    recording = run_node("""
        rclpy.init(); node = Echo(); rclpy.spin_once(node)
        twist = Twist(); twist.linear.x = 0.25
        node.publisher.publish(twist); rclpy.shutdown()
        node.publisher.publish(twist)
    """)
    assert [twist.linear.x for twist in sent(recording, "/cmd_vel")] == [0.0, 0.25]
    assert end_of(recording) == "exception"
    assert re.search("context is invalid|InvalidHandle", recording.ended.text)  # Jazzy, Kilted


CLOCKS = {
    "the node's": "node.get_clock()",
    "ROSClock()": "rclpy.clock.ROSClock()",
    "Clock()": "rclpy.clock.Clock()",
    "steady": "rclpy.clock.Clock(clock_type=rclpy.clock.ClockType.STEADY_TIME)",
    "ROS": "rclpy.clock.Clock(clock_type=rclpy.clock.ClockType.ROS_TIME)",
}


@pytest.mark.parametrize("clock", CLOCKS.values(), ids=CLOCKS)
def test_every_clock_of_rclpy_is_virtual(run_node: RunNode, clock: str) -> None:
    """Its timers, its sleep, and a busy wait on it, which ends."""
    recording = run_node(f"""
        import rclpy.clock
        from rclpy.duration import Duration
        rclpy.init(); node = Echo(); clock = {clock}
        start, ticks = clock.now(), []
        def tick():
            ticks.append(round((clock.now() - start).nanoseconds / 1e9, 3))
            if len(ticks) == 3: print(*ticks)
        timer = node.create_timer(0.25, tick, clock=clock)
        def nap():
            before = time.monotonic()
            print(clock.sleep_for(Duration(seconds=0.1)), round(time.monotonic() - before, 3),
                  timer.clock is clock)
            end, before = clock.now() + Duration(seconds=0.01), time.monotonic()
            while clock.now() < end: pass
            print(round(time.monotonic() - before, 2))
        threading.Thread(target=nap).start()
        rclpy.spin(node)
    """)
    assert end_of(recording) == "completed", recording
    assert said(recording) == ["True 0.1 True", "0.01", "0.25 0.5 0.75"]


def test_message_info_has_virtual_times(run_node: RunNode) -> None:
    recording = run_node("""
        class Late(Node):
            def __init__(self):
                super().__init__('late')
                self.create_subscription(LaserScan, '/scan', self.on_scan, 10)
            def on_scan(self, scan, info):
                now = self.get_clock().now().nanoseconds
                stamps = info['source_timestamp'], info['received_timestamp']
                print(*((now - stamp) / 1e9 for stamp in stamps))
                time.sleep(0.15)
        rclpy.init(); rclpy.spin(Late())
    """)
    ages = [[float(word) for word in line.split()] for line in said(recording)]
    # each scan waits for the callback before it: 0.05 s longer than the one before it did
    assert ages[:4] == [pytest.approx([0.05 * i, 0.05 * i], abs=1e-6) for i in range(4)]


ROSOUT = """
    from rcl_interfaces.msg import Log
    from rclpy.node import Node
    from rclpy.qos import DurabilityPolicy, QoSProfile
    rclpy.init({arguments}); node = Node({node})
    node.get_logger().info('before')
    heard = []
    past = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_subscription(Log, '/rosout', heard.append, {qos})
    node.get_logger().get_child('part').warning('after')
    rclpy.logging.get_logger('{name}.other').info('of no node')
    for _ in range(4): rclpy.spin_once(node, timeout_sec=0.01)
    for log in heard:
        age = node.get_clock().now().nanoseconds - rclpy.time.Time.from_msg(log.stamp).nanoseconds
        print(log.name, log.level, log.msg, log.function, 0 <= age < 1e9)
    rclpy.spin(node)
"""


OFF = "args=['--ros-args', '--disable-rosout-logs']"


@pytest.mark.parametrize(
    "arguments, node, qos, heard",
    [
        ("", "'talker'", "past", ["talker 20 before", "talker.part 30 after"]),
        ("", "'talker'", "10", ["talker.part 30 after"]),
        ("", "'talker', enable_rosout=False", "past", []),
        (OFF, "'talker'", "past", []),
    ],
)
def test_what_nodes_log_is_heard_on_rosout(
    run_node: RunNode, arguments: str, node: str, qos: str, heard: list[str]
) -> None:
    source = ROSOUT.format(arguments=arguments, node=node, name="talker", qos=qos)
    recording = run_node(source)
    assert end_of(recording) == "completed", recording
    assert said(recording) == [f"{line} <module> True" for line in heard]


@pytest.mark.parametrize("executor", ["SingleThreadedExecutor()", "MultiThreadedExecutor(3)"])
def test_a_coroutine_that_waits_for_a_slow_service(run_node: RunNode, executor: str) -> None:
    """It is not tried again and again while the pool runs something else."""
    recording = run_node(f"""
        from rclpy.callback_groups import ReentrantCallbackGroup
        from std_srvs.srv import Trigger
        def serve(request, response):
            time.sleep(0.3)
            response.message = str(round(time.monotonic() - start, 1))
            return response
        async def tick():
            answers.append((await client.call_async(Trigger.Request())).message)
            if len(answers) == 2:
                print(*answers); rclpy.shutdown()
        rclpy.init(); node = rclpy.create_node('n')
        group = ReentrantCallbackGroup(); start = time.monotonic(); answers = []
        node.create_service(Trigger, 'go', serve, callback_group=group)
        client = node.create_client(Trigger, 'go', callback_group=group)
        node.create_timer(0.5, tick, callback_group=group)
        executor = {executor}; executor.add_node(node); executor.spin()
    """)
    assert (end_of(recording), said(recording)) == ("returned", ["0.8 1.3"])


LATE = """
from rclpy.qos import DurabilityPolicy, QoSProfile
LATCHED = QoSProfile(depth=3, durability=DurabilityPolicy.TRANSIENT_LOCAL)
rclpy.init()
node = rclpy.create_node("late")
publisher = node.create_publisher(String, "/latched", LATCHED)
heard = node.create_publisher(String, "/heard", 10)
for number in range(4):
    publisher.publish(String(data=str(number)))
subscriptions = []
def subscribe():
    name = len(subscriptions)
    subscriptions.append(node.create_subscription(
        String, "/latched", lambda m: heard.publish(String(data=f"{name} {m.data}")), LATCHED
    ))
node.create_timer(0.05, subscribe)
rclpy.spin(node)
"""


def test_a_late_subscription_hears_all_of_it_at_once_in_every_run(run_node: RunNode) -> None:
    """DDS brings a history from a thread of its own, some real time later."""
    found = []
    for _ in range(2):
        run = run_node(LATE, 0.22)
        at = [m.time for m in run.published if m.topic == "/heard"]
        found.append(list(zip(at, (m.data for m in sent(run, "/heard")), strict=True)))
    right = [(50_000_000 * (k + 1), f"{k} {number}") for k in range(4) for number in range(1, 4)]
    assert found == [right, right]


@pytest.mark.parametrize("number, end", [("SIGINT", "KeyboardInterrupt"), ("SIGTERM", "none")])
def test_a_thread_interrupts_its_own_program(run_node: RunNode, number: str, end: str) -> None:
    recording = run_node(f"""
        import os, signal
        rclpy.init(); node = rclpy.create_node('n')
        threading.Timer(0.5, os.kill, [os.getpid(), signal.{number}]).start()
        end = 'none'
        try: rclpy.spin(node)
        except KeyboardInterrupt: end = 'KeyboardInterrupt'
        except rclpy.executors.ExternalShutdownException: pass
        print(end, round(time.monotonic() - 1000, 1), rclpy.ok())
    """)
    assert (end_of(recording), recording.now) == ("returned", pytest.approx(5e8))
    assert said(recording)[0].split()[::2] == [end, "False"]


def test_a_signal_ends_a_pause(run_node: RunNode) -> None:
    recording = run_node("""
        import os, signal
        signal.signal(signal.SIGUSR1, lambda number, frame: print('handled'))
        threading.Timer(0.5, os.kill, [os.getpid(), signal.SIGUSR1]).start()
        rclpy.init(); node = rclpy.create_node('n'); rclpy.spin_once(node, timeout_sec=0.1)
        signal.pause(); print('paused')
        threading.Timer(0.5, signal.raise_signal, [signal.SIGUSR1]).start()
        time.sleep(1.0); print('slept')
    """)
    assert said(recording) == ["handled", "paused", "handled", "slept"]
    assert recording.now == pytest.approx(1.5e9)
