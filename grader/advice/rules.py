"""Errors of rclpy, one rule an error: what was meant, and what it is called in ROS 2.

A rule fits an exception by its class, its text and the student's line. Each names the page on which
people ask about it, or which answers them. Where none fits, nothing is said.
"""

from __future__ import annotations

import re
from typing import NamedTuple

API = "https://docs.ros.org/en/jazzy/p/rclpy/"
NODES = API + "rclpy.node.html"
TIMES = API + "rclpy.time.html"
MIGRATION = (
    "https://docs.ros.org/en/jazzy/How-To-Guides/Migrating-from-ROS1/Migrating-Python-Packages.html"
)
PARAMETERS = API + "rclpy.parameter.html"
ASYNC = "https://github.com/ros2/rclpy/issues/962"
DEADLOCKS = "https://karelics.fi/deadlocks-in-rclpy/"
PYTHON = "https://docs.python.org/3/library/exceptions.html"


class Rule(NamedTuple):
    r"""What to say about one error; `\1` in `say` is the first group of `text`."""

    kind: str  # of the exception
    text: str  # what it says
    line: str  # what the student's line holds
    say: str
    source: str


CREATE = {  # method: how it is called
    "create_publisher": "create_publisher(Twist, '/cmd_vel', 10)",
    "create_subscription": "create_subscription(LaserScan, '/scan', self.scan_callback, 10)",
    "create_timer": "create_timer(0.1, self.tick)",
    "create_service": "create_service(Trigger, '/start', self.start_callback)",
    "create_client": "create_client(Trigger, '/start')",
}
ORDER = {
    "create_publisher": "the message type, the topic, the depth of its queue",
    "create_subscription": "the message type, the topic, the callback, the depth of its queue",
    "create_timer": "the period in seconds, the callback",
    "create_service": "the service type, the name, the callback",
    "create_client": "the service type, the name",
}
WRONG_ORDER = (  # of arguments; what Python says of them
    ("TypeError", r"rclpy_resolve_name\(\): incompatible function arguments"),
    ("TypeError", r"Expected QoSProfile or int, but received"),
    ("TypeError", r"^float\(\) argument must be .* not '(method|function)'"),
    ("TypeError", r"Node\.create_\w+\(\) (missing|takes)"),
    ("AttributeError", r"type object 'str' has no attribute '_TYPE_SUPPORT'"),
)

OWNED = (
    "a Node has a \\1 of its own: give yours another name, such as self.my_\\1 (executor, handle, "
    "context, publishers, subscriptions, timers, services and clients are the Node's)"
)
RCLPY_IN_ROS_1 = {  # name: what became of it
    "init_node": "rclpy.init(), then a class that is a Node: super().__init__('my_node')",
    "Publisher": "self.create_publisher(Twist, '/cmd_vel', 10), in a node",
    "Subscriber": "self.create_subscription(LaserScan, '/scan', self.scan_callback, 10), in a node",
    "Service": "self.create_service(type, name, callback), in a node",
    "ServiceProxy": "self.create_client(type, name), in a node, and call_async(request)",
    "Timer": "self.create_timer(0.1, self.tick), in a node",
    "Rate": "a timer, self.create_timer(0.1, self.tick): a loop with sleep() keeps callbacks away",
    "is_shutdown": "not rclpy.ok()",
    "sleep": "a timer: a callback that sleeps keeps the others away",
    "get_param": "self.declare_parameter(name, default), then self.get_parameter(name).value",
    "set_param": "self.set_parameters([Parameter(name, value=value)])",
    "get_time": "self.get_clock().now().nanoseconds / 1e9, in a node",
    "Time": "self.get_clock().now(), in a node; the class is rclpy.time.Time",
    "Duration": "rclpy.duration.Duration(seconds=0.5)",
    "wait_for_message": "a subscription that keeps the newest message in an attribute",
    "wait_for_service": "client.wait_for_service(timeout_sec=1.0)",
    **{name: f"self.get_logger().{name.removeprefix('log')}(…), in a node"
       for name in ("loginfo", "logerr", "logwarn", "logdebug")},
}  # fmt: skip
RCLPY_IN_ROS_1["logerr"] = "self.get_logger().error(…), in a node"
NODE_IN_ROS_1 = {
    "subscribe": "create_subscription", "create_subscriber": "create_subscription",
    "advertise": "create_publisher", "get_param": "get_parameter", "set_param": "set_parameters",
    "loginfo": "get_logger().info", "get_time": "get_clock().now", "now": "get_clock().now",
    "publish": "create_publisher(…), whose result has publish(message); Node has no",
}  # fmt: skip

IMPORTS = {  # names: the line that brings them
    "math|time|threading|json|random|statistics|rclpy|os|sys": r"import \1",
    "np": "import numpy as np",
    "Twist|Pose|PoseStamped|Point|Quaternion|Vector3|TwistStamped":
        r"from geometry_msgs.msg import \1",
    "LaserScan|Imu|Image": r"from sensor_msgs.msg import \1",
    "Float64|Float32|Bool|String|Int32|Empty": r"from std_msgs.msg import \1",
    "Trigger|SetBool": r"from std_srvs.srv import \1",
    "Odometry": r"from nav_msgs.msg import \1",
    "Node": r"from rclpy.node import \1",
    "SetParametersResult|ParameterDescriptor|FloatingPointRange|IntegerRange|ParameterType":
        r"from rcl_interfaces.msg import \1",
    "ExternalShutdownException|MultiThreadedExecutor": r"from rclpy.executors import \1",
    "ReentrantCallbackGroup|MutuallyExclusiveCallbackGroup":
        r"from rclpy.callback_groups import \1",
    "QoSProfile|ReliabilityPolicy|DurabilityPolicy|qos_profile_sensor_data":
        r"from rclpy.qos import \1",
}  # fmt: skip
KILTED = "https://docs.ros.org/en/kilted/Releases/Release-Kilted-Kaiju.html"
IN_KILTED = (  # kind of an exception, what it says: a name of rclpy's that Jazzy lacks
    ("ImportError", r"^cannot import name '(TimerInfo|TimerCancelledError)' from 'rclpy\.(?:timer|"
     r"node|executors|exceptions)'"),
    ("ModuleNotFoundError", r"'(rclpy\.subscription_content_filter_options)'"),
    ("AttributeError", r"^'\w+Executor' object has no attribute '(create_future)'"),
    ("AttributeError", r"^'Action\w+' object has no attribute '(configure_introspection)'"),
    ("TypeError", r"unexpected keyword argument '(rosout_qos_profile|content_filter_options|"
     r"wait_for_threads)'"),
    ("TypeError", r"^'(?:rclpy[\w.]+\.)?(Client|Publisher|Service|Subscription|Timer|Node)' object "
     "does not support the context"),
)  # fmt: skip
FROM = {names: line for names, line in IMPORTS.items() if line.startswith("from")}
MODULES = "math|time|json|random|statistics|threading|pickle|onnxruntime|numpy|torch|keras|joblib"
QOS = API + "rclpy.qos.html"
RULES = (
    Rule("TypeError", r"Expected QoSProfile or int.*QoSPresetProfiles", "",
         "a preset is not yet a profile, its value is: QoSPresetProfiles.SENSOR_DATA.value", QOS),
    *(
        Rule(kind, text, rf"\b{name}\s*\(", f"these go by order: {ORDER[name]}, and any others "
             f"by name (callback_group=…), as in self.{call}", NODES)
        for name, call in CREATE.items()
        for kind, text in WRONG_ORDER
    ),
    *(Rule(kind, text, "", "rclpy has this from ROS 2 Kilted on (\\1), and here it is Jazzy's",
           KILTED) for kind, text in IN_KILTED),
    Rule("AttributeError", r"property '(subscriptions|publishers|timers|clients|services|guards|"
         r"waitables|context|default_callback_group|handle)' of", "", OWNED, NODES),
    Rule("AttributeError", r"^(handle) cannot be modified", "", OWNED, NODES),
    Rule("AttributeError", r"has no attribute 'add_node'", r"self\.executor\s*=",
         OWNED.replace("\\1", "executor"), NODES),
    Rule("AttributeError", r"^property '(\w+)' of '\w+' object has no setter", "",
         "\\1 is a property, which can't be given a value: give the attribute another name",
         PYTHON),
    Rule("AttributeError", r"^'(property|member_descriptor|getset_descriptor)' object has no", "",
         "a class stands where one object of it belongs: brackets make one, as in twist = Twist()",
         "https://docs.python.org/3/tutorial/classes.html#class-objects"),
    Rule("TypeError", r"^Expected <class .*got <class '[\w.]*\.Metaclass_(\w+)'>", "",
         "\\1 is the class; \\1() is a message: publish one that you made", NODES),
    Rule("TypeError", r"'property' object is not iterable", r"\b(spin|spin_once|add_node)\s*\(",
         "spin() takes a node, not its class: node = MyNode(), then rclpy.spin(node)", API),
    Rule("TypeError", r"^spin(?:_once)?\(\) missing .*'node'", "",
         "there is no global node in ROS 2: node = MyNode(), then rclpy.spin(node)", MIGRATION),
    Rule("TypeError", r"descriptor '\w+' requires a 'super' object", "",
         'super is called, too: super().__init__("name_of_the_node")', PYTHON),
    Rule("RCLError", r"^Failed to create subscription: invalid allocator|with incompatible type",
         "", "a topic has one type: this program has an end of that name already, with another "
         "type. One of the two needs another type or another name", NODES),
    Rule("NotImplementedError", r"Service classes can not be instantiated", "",
         "a service type has two messages: Trigger.Request() and Trigger.Response()", NODES),
    Rule("TimeoutError", "^$", r"\.call\(", "from ROS 2 Kilted on call() raises TimeoutError where "
         "Jazzy's returns None: catch the one, and ask for the other", KILTED),
    Rule("TypeError", r"call_async\(\) missing|^$", r"\.call_async\(",
         "call_async takes a request object: client.call_async(Trigger.Request())", NODES),
    Rule("RuntimeError", r"Context\.init\(\) must only be called once", "",
         "rclpy.init() is called twice: once in main() is enough", API),
    Rule("RuntimeError", r"Executor is already spinning", "",
         "this spins in a callback, which is run by a spin that waits for it: return, and let the "
         "next callback go on", DEADLOCKS),
    Rule("InvalidHandle", "", "", "what is used here was destroyed before: does something come "
         "after destroy_node() or rclpy.shutdown()?", NODES),
    Rule("ValueError", r"name '.*\{.*unknown substitution", "",
         "the braces are still in the name: f before the text puts values in their place", PYTHON),
    Rule("InvalidTopicNameException", "", "",
         "the name of a topic has letters, digits, _ and /, and no blanks or dashes", NODES),
    Rule("InvalidNodeNameException", "", "",
         "the name of a node has letters, digits and _, no blanks, dashes or /", NODES),
    Rule("InvalidQoSProfileException", r"[Dd]epth", "",
         "give the profile a depth: QoSProfile(depth=10, …)", QOS),
    Rule("TypeError", r"QoSProfile.*takes 1 positional", "",
         "a profile takes its settings by name: QoSProfile(depth=10)", QOS),
    Rule("TypeError", r"\binit\(\) takes 0 positional", r"rclpy\.init",
         "rclpy.init takes its arguments by name: rclpy.init(args=args)", API),
    Rule("TypeError", r"^$", r"\bspin\w*\(",
         "a callback of a service has to give its answer back: `return response`", NODES),
    Rule("AssertionError", r"^The 'result' field must be a sub message of type '(\w+)_Result'", "",
         "an action's execute callback has to give a result back: goal_handle.succeed(), then "
         "`return \\1.Result()`", NODES),
    # queue_size, latch and other arguments of ROS 1
    Rule("TypeError", r"unexpected keyword argument 'queue_size'", "",
         "queue_size is ROS 1's: in ROS 2 the depth is the last argument, as in "
         "create_publisher(Twist, '/cmd_vel', 10)", MIGRATION),
    Rule("TypeError", r"unexpected keyword argument 'latch'", "",
         "there was a latch in ROS 1: in ROS 2 a QoSProfile(depth=1, durability="
         "DurabilityPolicy.TRANSIENT_LOCAL) takes the depth's place", MIGRATION),
    Rule("TypeError", r"unexpected keyword argument '(tcp_nodelay|buff_size|anonymous|oneshot)'",
         "", "ROS 1 alone has \\1: leave it out", MIGRATION),
    # time
    Rule("AttributeError", r"'Time' object has no attribute '(?:sec|nanosec)'", r"publish\(",
         "a stamp takes a message: self.get_clock().now().to_msg()", TIMES),
    Rule("AttributeError", r"'(Time|Duration)' object has no attribute '(?:to_n?secs?|secs|nsecs|"
         r"toSec|seconds|nanoseconds)' \(a message\)", "",
         "a stamp has the fields sec and nanosec: stamp.sec + stamp.nanosec / 1e9 are its seconds",
         TIMES),
    Rule("AttributeError", r"'(Time|Duration)' object has no attribute '(?:to_n?secs?|secs|nsecs|"
         r"toSec|seconds|to_seconds|total_seconds|sec)'", "",
         "a \\1 of rclpy counts nanoseconds: .nanoseconds / 1e9 are its seconds (a stamp in a "
         "message has sec and nanosec)", TIMES),
    Rule("AttributeError", r"type object 'Time' has no attribute '(now|get_rostime)'", "",
         "in ROS 2 a node has the clock: self.get_clock().now()", TIMES),
    Rule("TypeError", r"(?:for -|'[<>]=?' not supported).*'Time' and 'Time'", "",
         "one is a stamp of a message: Time.from_msg(stamp), of rclpy.time, makes both alike",
         TIMES),
    Rule("TypeError", r"Can't (?:subtract|compare) times with different clock types", "",
         "the two are of different clocks: take both from self.get_clock().now(); a stamp becomes "
         "Time.from_msg(stamp), an empty Time Time(clock_type=self.get_clock().clock_type)", TIMES),
    Rule("TypeError", r"Duration\.__init__\(\) takes 1 positional", "",
         "name its unit: Duration(seconds=0.5)", TIMES),
    Rule("TypeError", r"'int' object is not callable", r"\.nanoseconds\s*\(",
         "it is no method: leave the brackets after nanoseconds out", TIMES),
    Rule("AttributeError", r"'Header' object has no attribute '(seq)'", "",
         "a header has stamp and frame_id, and no seq as in ROS 1: count messages yourself",
         MIGRATION),
    # parameters
    Rule("TypeError", r"ParameterValue", "",
         "get_parameter_value() holds a field for each type: .double_value, .integer_value, …; "
         "get_parameter('…').value is the number itself", PARAMETERS),
    Rule("ParameterAlreadyDeclaredException", "", "",
         "the parameter is declared twice: once in the constructor is enough", PARAMETERS),
    Rule("ParameterUninitializedException", "", "",
         "it is declared without a default: declare_parameter('name', 0.5)", PARAMETERS),
    Rule("InvalidParameterValueException", r"Callback returned an invalid type", "",
         "what add_on_set_parameters_callback was given has to return a SetParametersResult on "
         "every path, with successful=True where all is well", PARAMETERS),
    Rule("TypeError", r"'(FloatingPoint|Integer)Range' object is not (?:subscriptable|iterable)|"
         r"'(?:\w+Range)' has no len", "",
         "a descriptor takes its range in a list: …_range=[\\1Range(from_value=…, to_value=…)]",
         PARAMETERS),
    Rule("AttributeError", r"^'list' object has no attribute '(?:name|value|type_)'", r"param\w*\.",
         "add_on_set_parameters_callback hands over a list, also of one Parameter: for parameter "
         "in parameters:", PARAMETERS),
    Rule("InvalidParameterTypeException", "expecting type 'BYTE_ARRAY'", "",
         "an empty list has no type, so rclpy takes it for bytes: declare_parameter('name', "
         "Parameter.Type.DOUBLE_ARRAY), or STRING_ARRAY, or a default of one item", PARAMETERS),
    Rule("InvalidParameterTypeException", "", "",
         "a parameter keeps the type of its default: 1.0 for a float, not 1", PARAMETERS),
    Rule("RCLError", r"'--params-file ([^']+)'\. Error: Cannot have a value before", "",
         "in \\1 belongs a node's name, below it ros__parameters: with two underscores, and below "
         "that NAME: VALUE", PARAMETERS),
    Rule("RCLError", r"'--params-file ([^']+)'\. Error: (?:Error parsing|while)", "",
         "\\1 is no YAML: indent by blanks, never by tabs, and leave one after each colon",
         PARAMETERS),
    # futures and coroutines
    Rule("AttributeError", r"'Future' object has no attribute '(\w+)'", "",
         "this is a future, which will hold the answer: answer = future.result(), in a function "
         "given to future.add_done_callback(…), then answer.\\1", DEADLOCKS),
    Rule("TypeError", r"'Future'", "", "this is a future, not yet the answer: future.result() is, "
         "in a function given to future.add_done_callback(…)", DEADLOCKS),
    Rule("RuntimeError", r"no current event loop in thread 'MainThread'", "",
         "from Python 3.14 on get_event_loop makes none: asyncio.run(main()), or loop = "
         "asyncio.new_event_loop(). Callbacks of rclpy run without one", ASYNC),
    Rule("RuntimeError", r"no (running|current) event loop", "",
         "callbacks of rclpy run without a loop of asyncio, so nothing of asyncio works in them: "
         "let a thread do the slow work, such as ThreadPoolExecutor(1).submit(…), or a timer",
         ASYNC),
    Rule("TypeError", r"coroutine", "",
         "a function with async def returns a coroutine: await it, in an async def, or make it a "
         "plain def", ASYNC),
    Rule("AttributeError", r"'numpy.ndarray' object has no attribute 'keys'", "",
         "a session takes a dict of its inputs: session.run(None, {name: array}), with the name of "
         "session.get_inputs()[0]", "https://onnxruntime.ai/docs/api/python/api_summary.html"),
    Rule("RuntimeError", r"must have the same dtype, but got Double and Float|expected .*Float but "
         r"found Double", "", "NumPy counts in float64, the model in float32: "
         "torch.from_numpy(features.astype(np.float32))",
         "https://pytorch.org/docs/stable/generated/torch.from_numpy.html"),
    # messages
    Rule("RuntimeError", r"service type provided is not valid", "",
         "a service's type is the whole of it, such as Trigger, which has Request and Response",
         NODES),
    Rule("AttributeError", r"'(?:float|int)' object has no attribute '[xyz]'", r"publish\(",
         "a number stands where a vector belongs: twist.linear.x = …, not twist.linear = …", NODES),
    Rule("TypeError", r"^expected a sequence in '(\w+)'", "",
         "`\\1` takes a list, also of one: \\1=[…]", NODES),
    Rule("TypeError", r"^dict is not a sequence", "", "a list of messages takes no dict: "
         "[KeyValue(key=key, value=text) for key, text in texts.items()]", NODES),
    Rule("TypeError", r"^'(\w+)' object is not (?:iterable|subscriptable)|"
         r"^object of type '(?:\w+)' has no len", r"\bscan\b(?!\.)",
         "a scan is a message with fields; its readings are scan.ranges",
         "https://docs.ros.org/en/jazzy/p/sensor_msgs/msg/LaserScan.html"),
    Rule("TypeError", r"RcutilsLogger\.\w+\(\) takes 2 positional arguments|rclpy_logging_rcutils",
         "", "a logger takes one text: info(f'speed {speed:.2f}')", NODES),
    Rule("ValueError", r"^Logger severity cannot be changed", "", "a line of code logs at one "
         "level only: write if and else, and each call of the logger on a line of its own", NODES),
    Rule("TypeError", r"Publisher\.publish\(\) takes 2 positional", "",
         "publish() takes one message: make it, fill its fields, publish it", NODES),
    Rule("AttributeError", r"has no attribute 'get_num_connections'", "",
         "in ROS 2 it is get_subscription_count()", MIGRATION),
    Rule("IndexError", "", r"\branges\s*\[\s*-?\d+", "which beam that is, and whether there is "
         "one, the scan says: beam i looks at angle_min + i * angle_increment, for i in "
         "range(len(scan.ranges))", "https://docs.ros.org/en/jazzy/p/sensor_msgs/msg/LaserScan.html"),
    Rule("TypeError", r"type ndarray is not JSON", "",
         "an array is several numbers: take the one that is meant, such as float(array.max())",
         "https://docs.python.org/3/library/json.html"),
    Rule("TypeError", r"type (Time|Duration) is not JSON", "",
         "JSON has no \\1: make seconds of it, stamp.sec + stamp.nanosec / 1e9",
         "https://docs.python.org/3/library/json.html"),
    Rule("ValueError", r"^generator already executing$", "",
         "two threads spin one executor, for rclpy.spin has one for the whole program: let each "
         "thread make its own, SingleThreadedExecutor(), add its node, and spin that",
         "https://github.com/ros2/rclpy/issues/1008"),
    # Python
    Rule("TypeError", r"must be integer, not 'slice'", "", "a deque has no slices: "
         "list(memory)[-10:], or let deque(maxlen=10) keep the last ten by itself",
         "https://docs.python.org/3/library/collections.html#collections.deque"),
    Rule("AttributeError", r"'maxlen' of 'collections.deque' objects is not writable", "",
         "a deque gets its length when it is made: deque(maxlen=10)",
         "https://docs.python.org/3/library/collections.html#collections.deque"),
    Rule("AttributeError", r"^can't set attribute|cannot assign to field", "", "a NamedTuple or a "
         "frozen dataclass can't be changed: make a new one, or give the value a name of its own",
         "https://docs.python.org/3/library/collections.html#collections.somenamedtuple._replace"),
    Rule("TypeError", r"must have 'read' and 'readline'", "",
         "pickle.load takes an open file: with open(path, 'rb') as file: pickle.load(file)",
         "https://docs.python.org/3/library/pickle.html#pickle.load"),
    Rule("TypeError", r"must have a 'write' attribute|must be str, not bytes$", "",
         "a pickle is bytes: with open(path, 'wb') as file: pickle.dump(model, file)",
         "https://docs.python.org/3/library/pickle.html#pickle.dump"),
    Rule("UnboundLocalError", rf"'({MODULES})'", "",
         "\\1 is given a value in this function, and so hides the module: rename one", PYTHON),
    Rule("UnboundLocalError", r"'(e|ex|exc|err|error|exception)'", "",
         "`\\1` is there only inside its `except … as \\1:`, and nothing was caught here", PYTHON),
    *(Rule(kind, rf"(?:cannot import name|module '[\w.]+' has no attribute) '({names})'", "",
           f"it is elsewhere: {line}", PYTHON)
      for names, line in FROM.items() for kind in ("ImportError", "AttributeError")),
    Rule("NameError", r"name '(onnxruntime|numpy|torch|keras|joblib|pickle)'", "",
         "`import \\1` is missing, or `import \\1 as …` has given it another name", PYTHON),
    Rule("ZeroDivisionError", "", r"\batan\(",
         "math.atan2(dy, dx) takes both, knows all four quadrants and never divides",
         "https://docs.python.org/3/library/math.html#math.atan2"),
    Rule("ValueError", r"min\(\)|max\(\)|empty", r"\[\s*-\w+\s*:\s*\w+\s*\]",
         "a slice from a negative index to a positive one is empty, for -90 counts from the end: "
         "which beams lie ahead, angle_min + i * angle_increment says",
         "https://docs.python.org/3/library/stdtypes.html#common-sequence-operations"),
    Rule("TypeError", r"list indices must be integers|array indices must be integers|"
         r"'float' object cannot be interpreted as an integer", "",
         "an index is an int: int(…), or // instead of /", PYTHON),
    Rule("TypeError", r"unsupported operand type\(s\) for .*'(list|array\.array|tuple)'", "",
         "arithmetic on a whole \\1 needs NumPy: np.array(scan.ranges)", PYTHON),
    Rule("TypeError", r"can't multiply sequence by non-int", "",
         "a list or a text can't be scaled: np.array(…) * factor, or float(text)", PYTHON),
    Rule("NameError", r"name '(true|false|null|none)'", "",
         "Python writes True, False and None", PYTHON),
    Rule("NameError", r"name '(?:nan|inf|pi|sqrt|cos|sin|atan2|hypot|isnan|isfinite|isinf)'", "",
         "it belongs to math: `import math`, then math.…", PYTHON),
    Rule("NameError", r"name '(raw_input|xrange|unicode|unichr|long)'", "",
         "\\1 is Python 2's: input, range, str, chr and int took its place", PYTHON),
    Rule("NameError", r"name 'rospy'", "", "that is ROS 1; in ROS 2 it is rclpy", MIGRATION),
    *(Rule("NameError", rf"name '({names})'", "", f"an import is missing: {line}", PYTHON)
      for names, line in IMPORTS.items()),
    Rule("Exception", "", r"^\s*raise\b", "this line raises it, and what leaves a callback ends "
         "the node: catch it there, and say what happened", PYTHON),
)  # fmt: skip

WAITS = (  # what a line that waits for good holds, and what to do
    (r"\.sleep\(", r"rate", "a rate's sleep() waits for a timer, which only the executor that "
     "runs this callback could fire: a timer's own callback needs no sleep, anything else becomes "
     "one, self.create_timer(0.1, self.tick)"),
    (r"\.call\(", "", "call() waits for an answer, which only the executor that runs this "
     "callback could deliver: call_async(request), and add_done_callback on its future"),
    (r"spin_until_future_complete|\.spin_once\(|\.spin\(", "", "a callback can't spin: it is run "
     "by a spin that waits for it; go on in future.add_done_callback(…)"),
    (r"wait_for_service", "", "wait for a service before spinning, not in a callback"),
    (r"wait_for_message", "", "in a callback nothing else is called back: keep the newest "
     "message in an attribute"),
    (r"\.result\(", "", "result() waits here for work that can't go on meanwhile: ask done() "
     "first, or use add_done_callback"),
    (r"\.acquire\(|\bwith self\.\w*lock", "", "a lock is waited for that its holder can't "
     "release: is it taken twice in one thread? Then an RLock, or one `with` less"),
    (r"\.wait\(|\.get\(|\.join\(", "", "what it waits for would have to come from another "
     "thread or callback, and none is running: does it need a timeout?"),
)  # fmt: skip


def rule_for(names: tuple[str, ...], text: str, line: str = "") -> str:
    """Return advice on an exception, by its classes, its text and the student's line."""
    for rule in RULES:  # compiled where a class fits: most nodes raise nothing
        if rule.kind not in names or not re.search(rule.line, line):
            continue
        if match := re.search(rule.text, text):
            return match.expand(rule.say) if match.re.groups else rule.say
    return ""


def wait_for_good(line: str) -> str:
    """Return advice on a line at which every thread of a node waits; "" if unknown."""
    for code, also, said in WAITS:
        if re.search(code, line) and re.search(also, line):
            return said
    return ""


def of_ros_1(owner: str, name: str) -> str:
    """Say what became of a name that was ROS 1's; `owner`: "rclpy" or "Node"."""
    if owner == "rclpy" and name in RCLPY_IN_ROS_1:
        return f"rospy.{name} was ROS 1; in ROS 2 it is {RCLPY_IN_ROS_1[name]}"
    if owner == "Node" and name in NODE_IN_ROS_1:
        return f"in ROS 2 it is self.{NODE_IN_ROS_1[name]}{' ' + name if name == 'publish' else ''}"
    return ""
