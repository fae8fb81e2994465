"""Submissions that aim at whoever reads the results: people, browsers, spreadsheets, parsers."""

from whole_class import kit

from grader.course.exercises import find_exercise

FILE = find_exercise("obstacle_avoidance").files[0]

# Files that never come to run: they aim at whoever looks into them.
FILES = {
    "coding rot13": b"# coding: rot13\n",
    "coding undefined": b"# coding: undefined\nimport rclpy\n",
    "coding of nothing": b"# coding: \x1b[31m<b>\n",
    "not UTF-8": "# Zoë\nimport rclpy\n".encode("latin-1"),
    "null bytes": b"import rclpy\0\n" * 100,
    "brackets": b"(" * 200_000,
    "deep blocks": b"".join(b" " * i + b"if 1:\n" for i in range(120)),
    "quotes": b"x = " + b'\\"' * 450_000,  # each might begin a string that ends on this line
    "long strings": b"'''\\\n" * 200_000,
    "surrogates": b"raise SystemExit('\\ud800\\udfff \\x1b[31m </script><b>')\n",
    "name of an error": b"class Evil(Exception):\n    def __str__(self): raise Evil\nraise Evil\n",
    "=1+1": b"raise ValueError('=cmd|calc!A0')\n",
}
# Nodes with the kit of the hostile ones; `scan` is called with each scan.
NODES = {
    "unseen log": """
def scan(node, _):
    print("\\x01" * 2000, "\\U0001f980" * 500, flush=True)
    print("\\x02" * 2000, file=sys.stderr, flush=True)
""",
    "backwards": """
def scan(node, _):
    print("\\u202e\\u2066gnp.exe \\u200f", "a" + "\\u0301" * 1500, flush=True)
    raise ValueError("\\u202eflah \\u2067 <b>" + "\\u0301" * 3000)
""",
    "no XML": """
def scan(node, _):
    raise AssertionError("\\ufffe\\uffff\\x0b\\x00\\ud800]]></failure><testcase name='x'/>")
""",
    "class of names": """
def scan(node, _):
    kind = type("Err\\n=1+1\\x1b[2J]]>" + "A" * 100_000, (Exception,), {})
    kind.__module__, kind.__qualname__ = "\\r\\n|calc", "\\u2028<img>" * 10_000
    error = kind("x" * 10_000_000)
    for number in range(3000):
        error.add_note(f"=note {number}")
    raise error
""",
    "causes": """
def scan(node, _):
    error = None
    for number in range(3000):
        next_one = ValueError(f"@cause {number}")
        next_one.__cause__ = error
        error = next_one
    raise ExceptionGroup("+group", [error, ExceptionGroup("-inner", [error] * 500)])
""",
    "numbers": """
VALUES = (float("nan"), float("inf"), -float("inf"), 1e308, 5e-324, -0.0, 1e16)
def scan(node, _):
    twist = Twist()
    twist.linear.x = twist.angular.z = VALUES[node.heard % len(VALUES)]
    node.cmd_vel.publish(twist)
""",
    "forged names": """
frames = sys.modules["rclpy_virtual_time.host.frames"]
def scan(node, _):
    odd = "\\u202e<!--=cmd|]]>\\ufffe\\x0b"
    for thing in gc.get_objects():
        if type(thing).__name__ == "Bridge":
            with attempt():
                thing._endpoints += [
                    frames.EndpointReport("publisher", odd * 20, odd + str(i), odd * 15,
                        odd, odd, 2**62, odd * 1000)
                    for i in range(400)
                ]
""",
    "forged messages": """
frames = sys.modules["rclpy_virtual_time.host.frames"]
def scan(node, _):
    for thing in gc.get_objects():
        if type(thing).__name__ == "Bridge":
            with attempt():
                for i in range(200):
                    topic = f"/\\u202e..//../x{i}\\n\\ufffe"
                    thing.published.append(
                        frames.Published(0, topic, "std_msgs/msg/String\\n=1", b"\\xff" * 900)
                    )
""",
    "forged end": """
frames = sys.modules["rclpy_virtual_time.host.frames"]
def scan(node, _):
    frame = sys._getframe()
    while frame and not hasattr(frame.f_locals.get("session"), "_wire"):
        frame = frame.f_back
    text = ("\\ufffe]]><b>\\u202e\\x0b\\n=1+1,\\"" * 2000)[:20_000]
    wire = frame.f_locals["session"]._wire
    wire.send(frames.Ended(0, "exception", text, text, []))
    time.sleep(1)
""",
    "marks of time": """
def scan(node, _):
    for number in (0, 10**30, -1):
        print(f"early\\x1e{number}\\n\\x1e{number}\\x1e", flush=True)
    print("[INFO] [nan] [x]: \\x1b]8;;http://x\\x07click\\x1b]8;;\\x07", flush=True)
""",
    "exit with words": """
class Odd(str):
    def __str__(self): return '=HYPERLINK("http://x","grade")' * 9000
    __repr__ = __str__
def scan(node, _):
    sys.exit(Odd())
""",
    "deep repr": """
def scan(node, _):
    deep = []
    for _ in range(50_000):
        deep = [deep]
    raise ValueError(deep)
""",
}
# Of students' folders. What no folder may be called (/, .., a null byte) needs no test.
NAMES = (
    "=cmd|calc!A0", "@SUM(A1)", "-1+1", "'; DROP TABLE units;--", "<img src=x onerror=alert(1)>",
    "\u202egnp.exe", "a\nb\r\tc", "\x1b[31mred", "con", "nul.txt", "a" * 200, "\u0301" * 60,
    "\U0001f980" * 40, "e\u0301", "\u00e9", "\uff21da", "ada", "Ada ", "ada.", "..x", "%2e%2e",
    "~ada", "ada~5a3861", "]]>", "&lt;b&gt;", "\ufeffada", "\u2028x",
    "javascript:alert(1)", "#", "?a=b",
)  # fmt: skip


def node(name: str) -> str:
    """Return the file of one of NODES."""
    head = "import gc\nimport sys\nimport time\nfrom kit import Twist, attempt, drive\n"
    return f"{kit()}{head}{NODES[name]}\n\ndrive(scan)\n"


def submissions() -> dict[str, bytes]:
    """Return all of them, by student."""
    return FILES | {name: node(name).encode() for name in NODES}
