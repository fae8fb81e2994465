"""What is said about errors of rclpy and of syntax: a row for each rule, with the real rclpy."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from grader.advice.deaths import account_of_syntax
from grader.advice.rules import RULES, wait_for_good
from rclpy_virtual_time import RosEnvironment

PRELUDE = """
import json, math, pickle, sys
import diagnostic_msgs.msg as d
import numpy as np
from collections import deque, namedtuple
from dataclasses import dataclass
import rclpy
from builtin_interfaces.msg import Time as Stamp
from diagnostic_msgs.msg import DiagnosticStatus as Status
from geometry_msgs.msg import Twist
from rclpy._rclpy_pybind11 import RCLError
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSPresetProfiles, QoSProfile
from rclpy.time import Time
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger
from grader.advice.message_words import field_of
from grader.advice.plain_words import plain_words
from grader.advice.rules import RULES
rclpy.init()
class Agent(Node):
    def tick(self): pass
    async def coroutine(self): pass
self = Agent('agent')
self.declare_parameter('speed', 1.0)
scan, stamp = LaserScan(), Stamp()
rclpy.init_node = None
del rclpy.init_node
"""
MEANT = {
    "self.create_publisher(Twist, '/c')": "the message type, the topic, the depth",
    "self.create_publisher('/c', Twist, 10)": "create_publisher(Twist, '/cmd_vel', 10)",
    "self.create_publisher(Twist, 10, '/c')": "the message type, the topic, the depth",
    "self.create_publisher('Twist', '/c', 10)": "the message type, the topic, the depth",
    "self.create_subscription(LaserScan, '/s', self.tick)": "the callback, the depth",
    "self.create_subscription('/s', LaserScan, self.tick, 10)": "the callback, the depth",
    "self.create_subscription(LaserScan, '/s', 10, self.tick)": "the callback, the depth",
    "self.create_timer(self.tick, 0.1)": "the period in seconds, the callback",
    "self.create_timer(0.1)": "the period in seconds, the callback",
    "self.create_service('/d', Trigger, self.tick)": "the service type, the name, the callback",
    "self.create_client('/d', Trigger)": "the service type, the name",
    "self.create_publisher(Twist, '/c', queue_size=10)": "queue_size is ROS 1's",
    "self.create_publisher(Twist, '/c', 10, latch=True)": "TRANSIENT_LOCAL",
    "self.create_subscription(LaserScan, '/s', self.tick, 10, tcp_nodelay=True)": "leave it out",
    "self.create_publisher(Twist, '/my topic', 10)": "no blanks or dashes",
    "Node('my node')": "no blanks, dashes",
    "self.subscriptions = []": "self.my_subscriptions",
    "self.handle = 3": "self.my_handle",
    "self.executor = 3": "self.my_executor",
    "Twist.linear.x = 1.0": "twist = Twist()",
    "self.create_publisher(Twist, '/c', 10).publish(Twist)": "Twist() is a message",
    "self.create_publisher(Twist, '/c', 10).publish(0.1, 0.2)": "publish() takes one message",
    "raise RuntimeError('mat1 and mat2 must have the same dtype, but got Double and Float')":
        "astype(np.float32)",
    "self.create_publisher(Twist, '/c', 10).get_num_connections()": "get_subscription_count()",
    "for n in 'info', 'warn': getattr(self.get_logger(), n)('a')": "logs at one level only",
    "rclpy.spin(Agent)": "node = MyNode()",
    "rclpy.spin()": "no global node",
    "rclpy.init()": "once in main()",
    "raise RCLError(\"file: '--params-file p.yaml'. Error: Cannot have a value before ros__par\")":
        "in p.yaml belongs a node's name",
    "raise RCLError(\"file: '--params-file p.yaml'. Error: Error parsing a event near line 1\")":
        "p.yaml is no YAML",
    "raise AssertionError(\"The 'result' field must be a sub message of type 'Go_Result'\")":
        "`return Go.Result()`",
    "self.get_parameter('speed').get_parameter_value() < 1.0": ".double_value",
    "float(self.get_parameter('speed').get_parameter_value())": ".double_value",
    "self.declare_parameter('speed', 1.0)": "declared twice",
    "from rclpy.parameter import Parameter as P\n"
    "Node('o', parameter_overrides=[P('e', value=['a'])]).declare_parameter('e', [])": "for bytes",
    "import rcl_interfaces.msg as r; self.declare_parameter('a', 1.0, r.ParameterDescriptor("
    "floating_point_range=r.FloatingPointRange()))": "=[FloatingPointRange(",
    "parameter = [1]; parameter.value": "hands over a list, also of one Parameter",
    "self.add_on_set_parameters_callback(lambda ps: ps); self.declare_parameter('b', 1.0)":
        "on every path",
    "Trigger()": "Trigger.Request()",
    "self.create_client(Trigger, '/d').call_async()": "a request object",
    "self.create_client(Trigger, '/d').call_async(Trigger.Request()).success": "answer.success",
    "self.create_client(Trigger, '/d').call_async(Trigger.Request())['a']": "future.result() is",
    "import asyncio; asyncio.get_running_loop()": "without a loop of asyncio",
    "raise RuntimeError(\"There is no current event loop in thread 'MainThread'.\")": "run(main())",
    "self.coroutine() + 1": "await it",
    "self.get_clock().now().to_sec()": ".nanoseconds / 1e9 are its seconds (a stamp",
    "(self.get_clock().now() - self.get_clock().now()).to_sec()": "A Duration of rclpy counts",
    "stamp.to_sec()": "stamp.sec + stamp.nanosec / 1e9",
    "stamp.secs": "stamp.sec + stamp.nanosec / 1e9",
    "self.get_clock().now() - stamp": "Time.from_msg(stamp)",
    "self.get_clock().now() < stamp": "Time.from_msg(stamp)",
    "Time() - self.get_clock().now()": "take both from self.get_clock().now()",
    "Time.now()": "self.get_clock().now()",
    "Duration(0.5)": "Duration(seconds=0.5)",
    "self.get_clock().now().nanoseconds()": "leave the brackets after",
    "scan.header.seq": "count messages yourself",
    "len(scan)": "its readings are scan.ranges",
    "min(scan)": "its readings are scan.ranges",
    "self.get_logger().info('speed', 0.5)": "a logger takes one text",
    "super.__init__('x')": "super is called, too",
    "[self.create_publisher(each, '/c', 10) for each in (Twist, LaserScan)]": "has one type",
    "[self.create_subscription(each, '/c', print, 1) for each in (Twist, Stamp)]": "has one type",
    "rclpy.Rate(10)": "self.create_timer(0.1, self.tick)",
    "rclpy.loginfo('hello')": "self.get_logger().info(…)",
    "rclpy.init_node('x')": "super().__init__('my_node')",
    "self.get_param('speed')": "self.get_parameter",
    "self.subscribe(LaserScan, '/scan', self.tick, 10)": "self.create_subscription",
    "self.publish(Twist())": "whose result has publish(message)",
    "t = Twist(); t.linearx = 1.0": "is it linear?",
    "t = Twist(); t.linear.X = 1.0": "it has x, y, z",
    "r = Trigger.Response(); r.sucess = True": "is it success?",
    "math.atan(1.0 / 0.0)": "math.atan2(dy, dx)",
    "min([1, 2, 3][-1:1])": "which beams lie ahead",
    "[1, 2][0.5]": "an index is an int",
    "[1.0] / 2.0": "np.array(scan.ranges)",
    "[1.0] * 2.0": "np.array(…) * factor",
    "true": "True, False and None",
    "sqrt(2)": "import math",
    "raw_input()": "Python 2's",
    "statistics.median([1])": "import statistics",
    "Odometry()": "from nav_msgs.msg import Odometry",
    "rospy.Rate(10)": "it is rclpy",
    "class P:\n    x = property(lambda self: 1)\nP().x = 2": "is a property",
    "self.create_publisher(Twist, '/c', QoSPresetProfiles.SERVICES_DEFAULT)": "its value is",
    "self.create_publisher(Twist, '/{side}/c', 10)": "f before the text",
    "self.create_service(Trigger.Response, '/d', self.tick)": "the whole of it",
    "t = Twist(); t.angular = 1; self.create_publisher(Twist, '/c', 10).publish(t)": "a vector",
    "p = self.create_publisher(d.DiagnosticArray, '/da', 10).publish\n"
    "p(d.DiagnosticArray(status=Status()))": "status=[…]",
    "h = LaserScan(); h.header.stamp = Time()\nself.create_publisher(LaserScan, 's', 9).publish(h)":
    "now().to_msg()",
    "self.create_publisher(Status, '/st', 10).publish(Status(values={'a': 'b'}))": "takes no dict",
    "QoSProfile(durability=DurabilityPolicy.VOLATILE)": "depth=10",
    "QoSProfile(5)": "settings by name",
    "rclpy.init(None)": "args=args",
    "def spin_once(): raise TypeError\nspin_once()": "`return response`",
    "scan.ranges[-1]": "angle_min + i * angle_increment",
    "json.dumps({'c': np.zeros(3)})": "float(array.max())",
    "json.dumps([self.get_clock().now()])": "JSON has no Time",
    "deque([1, 2])[:1]": "deque(maxlen=10)",
    "deque([1]).maxlen = 3": "when it is made",
    "namedtuple('P', 'x')(1).x = 2": "can't be changed",
    "dataclass(frozen=True)(type('P', (), {'__annotations__': {'x': int}}))(1).x = 2": "be changed",
    "pickle.load('model.pkl')": "'rb'",
    "pickle.dump(1, 'model.pkl')": "'wb'",
    "pickle.dump(1, open('/dev/null', 'w'))": "'wb'",
    "(lambda: [math := math.pi])()": "hides the module",
    "def f():\n try: 1\n except ValueError as err: 2\n return err\nf()": "inside its `except … as",
    "from std_msgs.msg import LaserScan": "from sensor_msgs.msg import LaserScan",
    "rclpy.Node('n')": "from rclpy.node import Node",
    "del pickle; pickle.dumps(1)": "`import pickle` is missing",
    "g = (next(g) for _ in range(2))\nnext(g)": "let each thread make its own",
    "raise ValueError('no scan')": "catch it there",
    "self.create_publisher(Status, '/st', 10).publish(Status(values=[d.KeyValue(value=3.5)]))":
        "`value` of KeyValue takes string, and was given 3.5",
}  # fmt: skip
NEWER = {  # on Jazzy, whose portable copy says the same
    "from rclpy.timer import TimerInfo": "from ROS 2 Kilted on (TimerInfo)",
    "from rclpy.subscription_content_filter_options import ContentFilterOptions": "Kilted on (rcl",
    "rclpy.get_global_executor().create_future()": "Kilted on (create_future)",
    "Node('m', rosout_qos_profile=1)": "Kilted on (rosout_qos_profile)",
    "with self.create_client(Trigger, '/d'): pass": "Kilted on (Client)",
}
if RosEnvironment.find().distro == "jazzy":
    MEANT |= NEWER
SYNTAX = {
    "```python\nimport math": "``` is Markdown",
    "%%node agent.py\nimport math": "Python only",
    "%matplotlib inline": "Python only",
    "!pip install numpy": "into a terminal",
    ">>> x = 1": "the prompt was copied",
    "12 def f():\n    pass": "numbers of the lines",
    "<<<<<<< HEAD\nx = 1": "Git left a conflict",
    "x = \N{LEFT DOUBLE QUOTATION MARK}a\N{RIGHT DOUBLE QUOTATION MARK}": "word processor",
    "x = 1 \N{EN DASH} 2": "type - for minus",
    "x =\N{NO-BREAK SPACE}1": "invisible character",
    "x = 2 \N{MULTIPLICATION SIGN} 3": "no such sign",
    "print 'hello'": "write print(…)",
    "try:\n    pass\nexcept TypeError, ValueError:\n    pass": "except X as error",
    "try:\n    pass\nexcept TypeError, ValueError as error:\n    pass": "except X as error",
    "if True:\n\tx = 1\n        y = 2": "never with tabs",
    "if True:\n    x = 1\n  y = 2": "like none around",
    "x = 1\n    y = 2": "indented more than the one before",
    "def f():\nx = 1": "isn't indented by four spaces",
    "if 1 > 0\n    pass": "ends with a colon",
    "x = (1": "( that opens here is never closed",
    "x = 1)": "closes what nothing opened",
    "x = (1]": "brackets close in pairs",
    "x = [1 2]": "a comma or an operator is missing",
    "x = 'hello": "the quote that opened it",
    'x = """hello': "three quotes",
    "if x = 1:\n    pass": "a comparison is written ==",
    "if f(a=1) >= 2 and y = 3:\n    pass": "a comparison is written ==",
    "f() = 1": "left of =",
    "x = 5m": "takes no unit",
    "return 1": "isn't indented like",
    "break": "belongs into a while or for",
    "x = 1\nx++": "x += 1",
    "if 1 && 2:\n    pass": "`and` and `or`",
    "if 1:\n    pass\nelse if 2:\n    pass": "elif",
    "f(a=1, 2)": "come after those without",
    "int x = 1": "needs no type",
    "function f() {}": "begins with `def`",
    'f"{1 of {2}"': "is closed by no }",
}  # fmt: skip
if sys.version_info >= (3, 14):
    SYNTAX["whlie True:\n    pass"] = "Did you mean 'while'?"
    # PEP 758
    del SYNTAX["try:\n    pass\nexcept TypeError, ValueError:\n    pass"]


def what_is_said(script: Path) -> dict[str, str]:
    """Return what is said about each source, by one process with the real rclpy."""
    script.write_text(f"""{PRELUDE}
said = {{}}
for source in json.loads(sys.stdin.read()):
    space = dict(globals())
    try:
        exec(source, space)
    except Exception as error:
        said[source] = field_of(error, space) or plain_words(error, source)
        if isinstance(error, NameError):
            said[source] = plain_words(error, source)
json.dump(said, open(sys.argv[1], 'w'))
""")
    out = script.with_suffix(".json")
    subprocess.run(
        [sys.executable, script, out], input=json.dumps(list(MEANT)), text=True, check=True,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])},
        stderr=subprocess.DEVNULL, timeout=120,
    )  # fmt: skip
    found: dict[str, str] = json.loads(out.read_text())
    return found


def test_an_error_of_rclpy_has_its_rule(tmp_path: Path) -> None:
    said = what_is_said(tmp_path / "script.py")
    wrong = {
        source: f"expected {meant!r}, got {said.get(source, 'no error')!r}"
        for source, meant in MEANT.items()
        if meant.lower() not in said.get(source, "").lower()
    }
    assert wrong == {}


@pytest.mark.filterwarnings("ignore::SyntaxWarning")
def test_a_syntax_error_is_explained_by_its_kind(tmp_path: Path) -> None:
    wrong = {}
    for number, (source, meant) in enumerate(SYNTAX.items()):
        file = tmp_path / f"agent_{number}.py"  # a name of its own: lines of a file are remembered
        file.write_text(source, "utf-8")
        with pytest.raises(SyntaxError) as caught:
            compile(source, str(file), "exec", dont_inherit=True)
        if meant not in (account := account_of_syntax(caught.value)):
            wrong[source] = f"expected {meant!r}, got {account!r}"
    assert wrong == {}


@pytest.mark.parametrize(
    ("line", "word"),
    [
        ("self.create_rate(10).sleep()", "create_timer"),
        ("answer = self.client.call(request)", "call_async"),
        ("rclpy.spin_until_future_complete(self, future)", "can't spin"),
        ("with self._lock:", "RLock"),
        ("self.done.wait()", "timeout"),
        ("x = 1", ""),
    ],
)
def test_a_wait_for_good_is_explained_by_its_line(line: str, word: str) -> None:
    assert word in wait_for_good(line)
    assert bool(word) == bool(wait_for_good(line))


def test_every_rule_names_a_page() -> None:
    assert all(rule.source.startswith("https://") for rule in RULES)
