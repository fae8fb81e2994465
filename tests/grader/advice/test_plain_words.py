"""What is said about the exceptions that beginners meet most often."""

import math

import numpy as np
import pytest

from grader.advice.plain_words import plain_words

CLASS = """
class Agent:
    def __init__(self):
        self.speed = 0.5
    def on_scan(self, scan):
        return scan
    def forgets(self):
        return speed
    def misspells(self):
        return self.sped
    def too_early(self):
        return self.publisher
    def wire(self):
        self.subscription = None
    def before(self):
        return self.subscription
    def get_logger(self):
        return self
    def logs(self):
        self.get_logger.info("hello")

class Forgets(Agent):
    def __init__(self):
        publisher = self.speed_publisher = 1
    def drive(self):
        return self.publisher

class Driver:
    def __init__(self):
        self._publishers = []
    def drive(self):
        return self.publisher

class RclpyNode:
    __module__ = "rclpy.node"
    def __init__(self, node_name):
        self._handle = node_name
    def wire(self):
        return self._handle
RclpyNode.__qualname__ = RclpyNode.__name__ = "Node"
RclpyNode.__init__.__qualname__ = "Node.__init__"

class NoSuper(RclpyNode):
    def __init__(self):
        self.wire()

class Misspelt(RclpyNode):
    def __int__(self):
        super().__init__("agent")
class Twist:
    def __init__(self, *, linear=None):
        pass

class Duration:
    pass
agent = Agent()
"""
MEANT = {
    "agent.on_scan()": "without brackets",
    "agent.on_scan(1, 2)": "first parameter say self",
    "agent.forgets()": "is it self.speed?",
    "agent.misspells()": "is it speed, not sped?",
    "agent.too_early()": "do so in __init__",
    "agent.before()": "used before it is given a value",
    "agent.logs()": "brackets are missing: get_logger is a function, so write get_logger().info",
    "Forgets().drive()": "write self.publisher = …",
    "Driver().drive()": "nothing has given self.publisher a value",  # no private name is offered
    "NoSuper()": "super().__init__('my_node')",
    "Misspelt()": "spelt __init__, with two underscores on either side",
    "(0.5).x": "write linear.x = …, not linear = …",
    "2.0 ^ 2.0": "x**2",
    "Twist(1.0)": "by name, such as Float64(data=1.0)",
    "raise TypeError(\"Expected <class 'std_msgs.msg._float64.Float64'>, got <class 'float'>\")": (
        "not what belongs in one"
    ),
    "import json; json.dumps(np.float32(1))": "not NumPy's",
    "raise TypeError('bad argument type for built-in operation')": "str(…) for a text",
    "raise ValueError('expected features of shape (n, 5), got (1, 1, 5)')": "one bracket too many",
    "raise SystemError('<method publish> returned a result with an exception set')": "another type",
    "Duration() > 0.5": "duration.nanoseconds / 1e9",
    "b'\\x80'.decode()": "open(path, 'rb')",
    "None()": "handed over by its name, without brackets",
    "raise RuntimeError('callback should be either be callable with one argument(to get')": (
        "the message and nothing else"
    ),
    "None < 1.0": "something is None",
    "f'{None:.2f}'": "something is None",
    "None.x": "something is None",
    "speed": "misspelt",
    "import wsgiref; wsgiref.validate": "write `import wsgiref.validate`",
    "import grader.nothing": "hand in the .ipynb",
    "get_ipython()": "only a notebook has it",
    "import pandass": "there is no pandass here",
    "import nunpy": "is it numpy?",
    "raise ModuleNotFoundError(name='onnxruntime.capi')": "only where a model needs it",
    "raise ValueError('Input X contains infinity or a value too large')": "neither NaN nor inf",
    "raise ValueError(\"Required inputs (['X']) are missing from input feed\")": "get_inputs()[0]",
    "[][0]": "indices 0 to n - 1",
    "{}['a']": "no such key",
    "1 / 0": "nothing to divide by",
    "min([])": "no usable reading",
    "bool(np.ones(2) > 0)": "any()",
    "np.ones(2) + np.ones(3)": "same length",
    "math.sqrt(-1)": "negative number",
    "math.cos(math.inf)": "angle of infinity",
    "int(math.nan)": "NaN",
    "int(math.inf)": "math.isfinite",
    "a, b = [1]": "as many values as names",
    "'v = ' + 1.0": 'f"',
    "(1)()": "no function",
    "for i in 5: pass": "a loop needs a list",
    "5[0]": "square brackets",
    "open('velocity_model.pkl')": "model_path",
    "def f(): return f()\nf()": "calls itself",
    "def f():\n    x += 1\nf()": "it needs `global`",
    "None | 1.0 == math.inf": "a condition needs `or`",
    "if 1 > 0\n    print(1)": "colon",
    "x = (1": "bracket",
}


@pytest.mark.filterwarnings("ignore::SyntaxWarning")
@pytest.mark.parametrize("source", MEANT)
def test_a_beginners_exception_is_explained(source: str) -> None:
    space = {"np": np, "math": math}
    with pytest.raises(Exception) as caught:
        exec(compile(CLASS + source, "agent.py", "exec"), space)
    assert MEANT[source] in plain_words(caught.value)


def test_an_exception_of_the_programs_own_is_not_explained() -> None:
    class Odd(Exception):
        def __str__(self) -> str:
            raise RuntimeError

    assert plain_words(RuntimeError("boom")) == ""
    assert plain_words(Odd()) == ""
