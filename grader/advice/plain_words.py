"""The exceptions that beginners meet most often, in plain words: what it means, and what to try.

Python says what it could not do. These lines say what most often leads there in a ROS node.
"""

from __future__ import annotations

import difflib
import dis
import importlib.util
import re
import sys
from collections.abc import Callable, Sequence
from types import BuiltinMethodType, FunctionType, MethodType, ModuleType
from typing import Any

from grader.advice.message_words import FIELD, lacks_field, types_of, with_article, wrong_field
from grader.advice.rules import of_ros_1, rule_for
from grader.advice.syntax_words import words_on_syntax

FUNCTIONS = (FunctionType, MethodType, BuiltinMethodType)
AXES = ("x", "y", "z")
NO_VALUE = (
    "something is None: does every path of the function that made it `return` a value, also at "
    "the limits, and has the first message come?"
)
HANDED = (
    "ROS hands a timer's callback nothing, a topic's the message, a service's request, response"
)
CALLED = (
    f"{HANDED}. Or is a method called where it should only be named, self.scan_callback without "
    "brackets?"
)
PARAMETER = "get_parameter('…') gives a Parameter; its value is get_parameter('…').value"

ONNX_NAMES = (
    "each model names its input and output itself: ask session.get_inputs()[0].name and "
    "session.get_outputs()[0].name"
)
LIBRARIES = ("rclpy", "numpy", "sklearn", "onnxruntime", "onnx", "skl2onnx", "joblib", "scipy",
             "math", "time", "random", "threading", "collections", "statistics")  # fmt: skip
SOMETIMES = ("sklearn", "onnxruntime", "torch", "keras")
INSTEAD = {  # module: what does the same here
    "grader": "a notebook has it: hand in the .ipynb, or the file that its %%node cell writes",
    "cv2": "it is for images, and the robot here has no camera; for a scan NumPy does",
    "pandas": "np.genfromtxt reads a CSV file",
    "matplotlib": "`course drive FILE --report drive.html` shows the run",
    "seaborn": "`course drive FILE --report drive.html` shows the run",
    "tensorflow": "`import keras` does without it, and onnxruntime runs a model that was exported",
    "xgboost": "scikit-learn has GradientBoostingRegressor",
    "tf_transformations": "math does: yaw = math.atan2(2 * (w*z + x*y), 1 - 2 * (y*y + z*z))",
    "transforms3d": "math does: yaw = math.atan2(2 * (w*z + x*y), 1 - 2 * (y*y + z*z))",
    "transformations": "math does: yaw = math.atan2(2 * (w*z + x*y), 1 - 2 * (y*y + z*z))",
    "quaternion": "math does: yaw = math.atan2(2 * (w*z + x*y), 1 - 2 * (y*y + z*z))",
    "filterpy": "a filter of a few lines needs NumPy only", "numba": "NumPy's own loops are fast",
    "requests": "a node has no network here: what it needs lies in a file beside it",
    "laser_geometry": "x = r * math.cos(angle) and y = r * math.sin(angle) make points of a scan",
    "cv_bridge": "np.frombuffer(image.data, np.uint8) makes an array of an image",
    "ros_numpy": "np.array(scan.ranges) makes an array of a scan",
}  # fmt: skip
THERE = (
    "Python's own modules, rclpy and ROS messages, numpy, scikit-learn and onnxruntime; a training "
    "script also onnx, skl2onnx and joblib"
)

# (exception, what its text matches, what to try); the first that fits is told.
COMMON: tuple[tuple[str, str, str], ...] = (
    (
        "TypeError",
        r"Node\.__init__\(\) missing .*'node_name'",
        "a node needs a name: super().__init__('my_node'), in a method that is spelt __init__, "
        "with two underscores on either side",
    ),
    (
        "RuntimeError",
        r"callback should be either be callable with one argument",
        "a subscription's callback takes the message and nothing else: "
        "def scan_callback(self, scan), handed over as self.scan_callback",
    ),
    ("TypeError", r"missing \d+ required positional argument", CALLED),
    (
        "TypeError",
        r"__init__\(\) takes 1 positional argument but",
        "a message takes its fields by name, such as Float64(data=1.0); in a class of your own, is "
        "self the first parameter of __init__?",
    ),
    (
        "TypeError",
        r"^Expected <class '[\w.]*msg[\w.]*'>, got <class",
        "publish() takes a message of the publisher's own type, not what belongs in one: first "
        "make that message, and fill it in",
    ),
    (
        "TypeError",
        r"not JSON serializable",
        "JSON knows Python's own numbers and texts, not NumPy's: write float(x), int(x) or str(x)",
    ),
    (
        "TypeError",
        r"bad argument type for built-in operation|^\w+ is not a sequence|must be real number",
        FIELD,
    ),
    ("SystemError", r"publish\b.*exception set", FIELD),
    (
        "TypeError",
        r"'Duration'|'Time'",
        "a Time and a Duration count nanoseconds and are no numbers: duration.nanoseconds / 1e9 "
        "are its seconds",
    ),
    (
        "TypeError",
        r"takes \d+ positional arguments? but \d+ (was|were) given",
        f"does the method's first parameter say self? And {HANDED}",
    ),
    ("TypeError", r"for \^", "`^` is not a power in Python: write x**2"),
    ("TypeError", r"'Parameter'|not Parameter$", PARAMETER),
    ("RuntimeError", r"rclpy\.parameter\.Parameter object", PARAMETER),
    *(
        (
            "ModuleNotFoundError",
            rf"No module named '{name}\b",
            f"there is no {name} here; {instead}",
        )
        for name, instead in INSTEAD.items()
    ),
    ("TypeError", r"Parameter\b.*\bfloat|float.*\bParameter\b", PARAMETER),
    (
        "TypeError",
        r"^'NoneType' object is not callable",
        "a callback is handed over by its name, without brackets: create_timer(0.1, self.tick), "
        "not self.tick(), which calls it there and then and hands over None",
    ),
    (
        "TypeError",
        r"unsupported operand type\(s\) for [|&]",
        "| and & compute with bits, and before any comparison: a condition needs `or` and `and`",
    ),
    ("TypeError", r"NoneType", NO_VALUE),
    ("AttributeError", r"^'NoneType' object", NO_VALUE),
    (
        "TypeError",
        r"'\w+' object is not callable",
        "there are brackets after something that is no function; does a variable have the name of "
        "a function, such as min or sum?",
    ),
    (
        "TypeError",
        r"not subscriptable|does not support indexing",
        "square brackets need a list, an array or a dict",
    ),
    ("TypeError", r"not iterable", "a loop needs a list; one number is none"),
    (
        "TypeError",
        r"can only concatenate str|must be str, not",
        'a text and a number can\'t be added: write f"… {number:.2f}"',
    ),
    (
        "TypeError",
        r"only length-1 arrays|only 0-dimensional arrays",
        "this needs one number, and got an array: take one number of it, such as x.item() of "
        "a table with just one, x.max() of probabilities, x[0] of a row",
    ),
    (
        "AssertionError",
        r"field must be of type 'float'|must be a float|of type 'float'",
        "a float field takes a float, not an int or None: write 0.0 for 0, or float(…)",
    ),
    (
        "AssertionError",
        r"field must be (?!a set or sequence)",
        "the field takes another type: `ros2 interface show TYPE` lists them",
    ),
    (
        "UnboundLocalError",
        r"",
        "a name that a function assigns is its own: give it a value first, on every path. If the "
        "module's is meant, it needs `global`, and is better kept in self",
    ),
    ("NameError", "'get_ipython'", "only a notebook has it: hand in what its %%node cell writes"),
    ("NameError", r"", "is it misspelt, or does it lack `self.` or an import?"),
    (
        "IndexError",
        r"list index out of range|array index|out of bounds|index out of range",
        "a list of n items has the indices 0 to n - 1; and an empty scan has none",
    ),
    ("KeyError", r"", "the dict has no such key: is it misspelt, or not filled yet?"),
    (
        "ZeroDivisionError",
        r"",
        "what if there is nothing to divide by: a range of 0.0 (no echo, for many lidars), the "
        "length of an empty list, the time between equal stamps?",
    ),
    (
        "ValueError",
        r"min\(\)|max\(\)|zero-size array|empty sequence|iterable argument is empty",
        "there may be no usable reading at all: ask before min()",
    ),
    (
        "ValueError",
        r"truth value of an array",
        "an array is many answers: `is None` asks whether there is one, & and | combine two "
        "(each in brackets), .any() or .all() makes one of them",
    ),
    (
        "ValueError",
        r"\(n, 5\), got \(\d+, (?![15]\b)\d+\)",
        "the model wants five features in each row: print what you hand it; is one missing, or are "
        "they readings?",
    ),
    (
        "ValueError",
        r"got 1D array instead:\s*array=\[[^\]]*\.\.\.",
        "a table is wanted and a column of many numbers came: fit takes the features, a row for "
        "each sample, and then the labels",
    ),
    (
        "ValueError",
        r"features of shape.*got \(1, 1, \d+\)|Found array with dim 3",
        "one bracket too many: features is a table of one row already, so predict(features), and "
        "not predict([features])",
    ),
    (
        "ValueError",
        r"Expected 2D array|expecting \d+ features|features of shape|Reshape your data",
        "the model wants a row for each sample, (1, 5) here: features.reshape(1, -1)",
    ),
    (
        "ValueError",
        r"broadcast|shape mismatch|inhomogeneous|all the input array",
        "two arrays don't have the same length: print their shapes",
    ),
    (
        "ValueError",
        r"math domain error|expected a (\w+ input|number between)",
        "a root or a logarithm of a negative number, or an angle of infinity",
    ),
    (
        "ValueError",
        r"cannot convert float NaN|could not convert|invalid literal",
        "this is no number: a scan may hold NaN, a text may hold anything",
    ),
    ("UnicodeDecodeError", r"", "a pickle is bytes and no text: open(path, 'rb')"),
    ("ValueError", r"unpack", "there are not as many values as names on the left"),
    (
        "OverflowError",
        r"infinity",
        "a scan may hold infinity, which has no int: ask math.isfinite first",
    ),
    (
        "ValueError",
        r"contains (infinity|NaN)",
        "a model takes neither NaN nor infinity: leave such readings out of the features, or put a "
        "number in their place",
    ),
    ("InvalidArgument", r"Invalid (output|input|Feed Input) ?[Nn]ame", ONNX_NAMES),
    ("ValueError", r"missing from input feed", ONNX_NAMES),
    (
        "InvalidArgument",
        r"Got invalid input|Invalid rank|INVALID_ARGUMENT",
        "ONNX wants float32 of the shape of its input, (1, 5) here: "
        "features.astype(np.float32).reshape(1, -1)",
    ),
    (
        "FileNotFoundError",
        r"",
        "the file is looked for in the folder from which the node was started; a model's path "
        "comes from the parameter model_path",
    ),
    ("RecursionError", r"", "a function calls itself for ever"),
    ("NotInitializedException", r"", "rclpy.init() comes first, before any node is made"),
    (
        "ParameterNotDeclaredException",
        r"",
        "declare it in the constructor: self.declare_parameter('name', default)",
    ),
)


def plain_words(error: BaseException, line: str = "") -> str:
    """Return advice on an exception: its usual reason, and what to try; "" if unknown.

    `line` is the student's, in which it was raised.
    """
    try:
        return _words(error, line)
    except Exception:  # the exception is the program's own, and may be anything
        return ""


def _words(error: BaseException, line: str) -> str:
    text = str(error)
    if isinstance(error, SyntaxError):
        return words_on_syntax(error.msg, line or error.text or "")
    owner = getattr(error, "obj", None)
    of_message = bool(types_of(owner))
    names = tuple(kind.__name__ for kind in type(error).__mro__)
    if said := rule_for(names, f"{text} (a message)" if of_message else text, line):
        return said
    special = SPECIAL.get(type(error).__name__)
    if special and (said := special(error)):
        return said
    said = words_for(names, text)
    return wrong_field(error) or said if said == FIELD else said


def words_for(names: Sequence[str], text: str) -> str:
    """Return advice, by the names of an exception's classes and its text."""
    if said := rule_for(tuple(names), text, text):
        return said
    for name, fits, advice in COMMON:
        if name in names and re.search(fits, text):
            return advice
    return ""


def _module(error: Any) -> str:
    """Name a substitute for a module that is not installed."""
    name = str(error.name or "").partition(".")[0]
    if name in INSTEAD:
        return ""
    near = difflib.get_close_matches(name, LIBRARIES, n=1, cutoff=0.75)
    if near and near[0] != name:
        return f"is it {near[0]}?"
    if name in SOMETIMES:
        return (
            f"{name} is not installed here: install it beside `course`. Not every machine has it, "
            "so import it only where a model needs it, inside try … except"
        )
    return (
        f"there is no {name} here: is it a file of yours? Then hand in {name}.py, too. Otherwise "
        f"what is handed in may import {THERE}. A drive finds what is installed beside `course`"
    )


def _attribute(error: Any) -> str:
    """Say which attributes there are instead."""
    owner, name = getattr(error, "obj", None), getattr(error, "name", None)
    if owner is None or not isinstance(name, str):
        return ""
    if isinstance(owner, ModuleType) and (said := of_ros_1(owner.__name__, name)):
        return said
    if _is_node(owner) and (said := of_ros_1("Node", name)):
        return said
    if isinstance(owner, ModuleType) and _has_module(owner, name):
        package = owner.__name__
        return f"`import {package}` does not bring it: write `import {package}.{name}`"
    if fields := types_of(owner):
        return lacks_field(type(owner).__name__, name, fields)
    if isinstance(owner, FUNCTIONS):
        method = getattr(owner, "__name__", "it")
        return f"brackets are missing: {method} is a function, so write {method}().{name}"
    if isinstance(owner, int | float) and name in AXES:
        return f"a number stands where a vector belongs: write linear.{name} = …, not linear = …"
    if hasattr(type(owner), name.strip()) or isinstance(owner, type):
        return ""
    return _own_attribute(owner, name, by_itself=_self_in(error) is owner)


def _is_node(owner: Any) -> bool:
    return any(base.__module__ == "rclpy.node" for base in type(owner).__mro__)


def _has_module(package: ModuleType, name: str) -> bool:
    """Return whether a module of a package exists, imported or not."""
    paths = getattr(package, "__path__", None)
    return paths is not None and importlib.util.find_spec(f"{package.__name__}.{name}") is not None


def _own_attribute(owner: Any, name: str, *, by_itself: bool) -> str:
    """Say what became of an attribute of an object; `by_itself`: a method of its own asked."""
    cls = type(owner)
    if name.startswith("_") and any(base.__module__.startswith("rclpy.") for base in cls.__mro__):
        return "does __init__ begin with super().__init__('my_node')? That makes it a node"
    if _is_given_somewhere(cls, name):
        return f"self.{name} is used before it is given a value: do that first, in __init__"
    if name in _locals(cls):
        return (
            f"without self. in front, {name} = … is a variable of its method, and gone when that "
            f"returns: write self.{name} = …"
        )
    known = [*getattr(owner, "__dict__", {}), *vars(cls)]
    known = [each for each in known if each.startswith("_") == name.startswith("_")]
    near = difflib.get_close_matches(name, known, n=1)
    if near:
        return f"is it {near[0]}, not {name}?"
    if by_itself:
        return (
            f"nothing has given self.{name} a value yet: do so in __init__, before it is used "
            "and before anything can call back"
        )
    return f"{with_article(cls.__name__)} has no {name}"


def _locals(cls: type) -> set[str]:
    """Return the names of the variables of a class's __init__."""
    start = vars(cls).get("__init__")
    return set(start.__code__.co_varnames) if isinstance(start, FunctionType) else set()


def _is_given_somewhere(cls: type, name: str) -> bool:
    """Return whether a method of the class gives `self.NAME` a value."""
    codes = [method.__code__ for method in vars(cls).values() if isinstance(method, FunctionType)]
    return any(
        step.opname == "STORE_ATTR" and step.argval == name
        for code in codes
        for step in dis.get_instructions(code)
    )


def _self_in(error: Any) -> Any:
    """Return the object whose method raised; None if it was no method."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    return trace.tb_frame.f_locals.get("self") if trace else None


def _name(error: Any) -> str:
    """Say that `self.` is missing, where the object has an attribute of that name."""
    name, owner = getattr(error, "name", None), _self_in(error)
    if name == "self":
        return "only a method has self, as its first parameter: hand a function what it needs"
    if isinstance(name, str) and owner is not None and name in {*vars(owner), *dir(type(owner))}:
        return f"is it self.{name}?"
    return ""


def _import(error: Any) -> str:
    """Name the attribute of a module that is nearest to a missing name."""
    module, name = sys.modules.get(str(error.name)), re.search(r"import name '(\w+)'", str(error))
    near = difflib.get_close_matches(name[1], dir(module), n=1) if module and name else []
    return f"is it {near[0]}?" if near else ""


SPECIAL: dict[str, Callable[[Any], str]] = {
    "ImportError": _import,
    "AttributeError": _attribute,
    "NameError": _name,
    "ModuleNotFoundError": _module,
}
