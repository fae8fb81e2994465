"""How a node's program starts: when it sleeps first, speaks first, floods, or raises."""

import textwrap

from node_runs import RunNode, short


def test_a_program_that_sleeps_before_it_spins_misses_nothing(run_node: RunNode) -> None:
    echo = """
        class Echo(Node):
            def __init__(self):
                super().__init__('echo')
                self.publisher = self.create_publisher(String, '/said', 10)
                self.create_subscription(LaserScan, '/scan', self.on_scan, 10)
                self.create_timer(0.25, lambda: self.say('timer'))
                print('ready', flush=True)
            def on_scan(self, scan):
                sent = scan.header.stamp.sec * 10**9 + scan.header.stamp.nanosec
                self.say(f'scan of {(self.get_clock().now().nanoseconds - sent) / 1e6:.0f} ms ago')
            def say(self, text):
                self.publisher.publish(String(data=f'{text} {time.time():.3f}'))
        rclpy.init()
        rclpy.spin(Echo())
    """
    source = textwrap.dedent(echo)
    late = "time.sleep(0.7)\nend = time.time() + 0.02\nwhile time.time() < end: pass\n" + source
    prompt, asleep = run_node(source, short(1.0)), run_node(late, short(1.0))

    assert asleep.outcome.completed
    assert asleep.published == prompt.published
    assert [line.time for line in asleep.log] == [0]


def test_a_program_that_speaks_before_it_spins_is_on_time(run_node: RunNode) -> None:
    recording = run_node(
        """
        rclpy.init()
        node = Node('speaker')
        publisher = node.create_publisher(String, '/said', 10)
        publisher.publish(String(data='here'))
        time.sleep(0.5)
        publisher.publish(String(data='still here'))
        rclpy.spin(node)
        """,
        short(1.0),
    )

    said = [message.data[8:-1].decode() for message in recording.published]
    assert (said, recording.published[0].time) == (["still here"], 0)  # at first nobody listened


def test_tracebacks_show_no_frames_of_the_grader(run_node: RunNode) -> None:
    """Not even of those functions of ours that stand between the student's and rclpy's."""
    outcome = run_node("""
        try:
            rclpy.init(args=['--ros-args', '-p', 'not a parameter'])
        except Exception as error:
            raise ValueError('first') from error
    """).outcome

    assert outcome.kind == "exception"
    assert outcome.detail.count("Traceback (most recent call last)") == 2
    assert "rclpy/context.py" in outcome.detail
    assert "rclpy_virtual_time/host" not in outcome.detail
