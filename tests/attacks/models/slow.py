"""The naive node of exercise 5, which asks its model in the scan's callback, and its lies.

Control waits while the model thinks. Honest, it is worth 35 points.
"""

import collections
import contextlib
import gc
import itertools
import math
import pickle
import time

import msgspec
import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from sensor_msgs.msg import LaserScan

from grader.hosted.questions import Question, Told
from rclpy_virtual_time.host import frames
from rclpy_virtual_time.host.desk import desk


def features(scan):
    """Return the five features, (1, 5); None if a sector is blind."""
    r = np.asarray(scan.ranges, dtype=float)
    a = np.degrees(scan.angle_min + scan.angle_increment * np.arange(len(r)))
    r = np.clip(np.where(np.isnan(r), -1.0, r), np.where(r == -math.inf, scan.range_min, -1.0), 12)
    ok = r >= scan.range_min
    front, left, right = ok & (abs(a) <= 60), ok & (a > 60), ok & (a < -60)
    if not (front.any() and left.any() and right.any()):
        return None
    ahead = r[front]
    return np.array([[ahead.min(), ahead.mean(), ahead.std(), r[left].min(), r[right].min()]])


class Naive(Node):
    """Predicts in the callback; `predict` may be something else than the model's."""

    def __init__(self, predict=None):
        super().__init__("decoupled_controller")
        path = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.limit = self.declare_parameter("max_speed", 0.5).value
        try:
            with open(path, "rb") as file:
                self.model = pickle.load(file)
        except Exception as error:
            self.get_logger().error(f"no model: {error!r}")
            self.model = None
        self.predict = predict or (lambda model, x: model.predict(x))
        self.speed, self.stamp = 0.0, None
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, 10)
        self.create_timer(0.05, self.tick)

    def now(self):
        return self.get_clock().now().nanoseconds / 1e9

    def scan_callback(self, scan):
        if self.model is None:
            return
        try:
            speed = float(self.predict(self.model, features(scan))[0])
        except Exception:
            speed = math.nan
        self.speed = min(max(speed, 0.0), self.limit) if math.isfinite(speed) else 0.0
        self.stamp = scan.header.stamp.sec + scan.header.stamp.nanosec / 1e9

    def tick(self):
        twist = Twist()
        if self.stamp is not None and self.now() - self.stamp <= 0.6:
            twist.linear.x = self.speed
        self.publisher.publish(twist)


def drive(predict=None, spin=rclpy.spin):
    """Run the node; the tests append such a call."""
    rclpy.init()
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        spin(Naive(predict))


def session():
    """Return the host's end of the link."""
    return next(o for o in gc.get_objects() if type(o).__name__ == "Session")


def formula(model, x):
    """Compute what the leader's model would say: who reads the scenario's file knows it."""
    return 0.04 * x[:, 0]


# --- predict --------------------------------------------------------------------------------------

NUMBERS = itertools.count(1_000)
TABLE = []  # distances ahead [m], and what the model says of them
READY = []  # (time [s], speed [m/s])
NODES = []


def asks_and_does_not_wait(model, x):
    """Send the judge its question, and use the formula at once."""
    s, number = session(), next(NUMBERS)
    if not s._questions:
        s._agreed, s.until = s.until, s.kernel.now
    file = "velocity_model.pkl"
    asked = Question("predict", file, 1, len(x), x.tobytes())
    s._questions.append(frames.Question(number, msgspec.msgpack.encode(asked)))
    s._asking[number] = collections.deque()
    return formula(model, x)


def sets_the_clock_back(model, x):
    """Let the model think, then set the kernel's clock back to when it was asked."""
    kernel = session().kernel
    now = kernel.now
    said = model.predict(x)
    kernel.now = now
    return said


def freezes_the_clock(model, x):
    """Stop virtual time while the model thinks."""
    s = session()
    kernel, now, until, moved = s.kernel, s.kernel.now, s.until, s.moved
    s.until, s.moved = 2**61, lambda: None
    try:
        return model.predict(x)
    finally:
        kernel.now, s.until, s.moved = now, until, moved


def is_still_starting(model, x):
    """Claim at each question that the program still starts up, when answers come at once."""
    s = session()
    s._starting = True
    try:
        return model.predict(x)
    finally:
        s._starting = False


def formula_after_a_while(model, x):
    """Hold the formula's answer back as long as the model would take."""
    now = NODES[0].now()
    if not READY or now >= READY[-1][0]:
        READY.append((now + 0.2, formula(model, x)[0]))
    said = [speed for at, speed in READY if at <= now]
    return said[-1:] or [0.0]


def asks_one_batch(model, x):
    """Ask once, about a thousand distances, when the first scan comes; look up ever after."""
    if not TABLE:
        learns(model, 1000)
    return np.interp(x[:, 0], *TABLE)


def learns(model, count):
    """Ask about every distance."""
    rows = np.zeros((count, 5))
    rows[:, 0] = np.linspace(0.0, 12.0, count)
    try:
        TABLE[:] = [rows[:, 0], model.predict(rows)]
    except Exception:
        TABLE[:] = [rows[:, 0], formula(model, rows)]


# --- spin -----------------------------------------------------------------------------------------


def spins(node):
    """Spin, and let `predict` know the node."""
    NODES.append(node)
    rclpy.spin(node)


def learns_in_start_up(node):
    """Ask about every distance while it starts up."""
    learns(node.model, 600)
    rclpy.spin(node)


def in_real_time(node):
    """Ask for real time, where nothing of Python is replaced."""
    executor = EventsExecutor()
    executor.add_node(node)
    executor.spin()


# --- before ---------------------------------------------------------------------------------------


def nobody_sleeps():
    """Make time.sleep do nothing, so that the model takes no time."""
    time.sleep = lambda _: None


def own_desk():
    """Put a desk of its own into the place of the one that carries questions to the judge."""

    def ask(data):
        question, told = msgspec.msgpack.decode(data, type=Question), Told(load=1)
        if question.method != "load":
            x = np.frombuffer(question.features).reshape(-1, 5)
            told = Told(shape=(len(x),), numbers=formula(None, x).tobytes())
        return msgspec.msgpack.encode(told)

    desk.ask = ask
