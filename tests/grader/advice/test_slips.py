"""What is said about lines that can't mean what they say: a row for each, and what is none."""

import pytest

from grader.advice.slips import SAID, said_in, slips

ASKED = "self.add_on_set_parameters_callback(self.may_be)\ndef may_be(self, ps):\n    "
TOLD = "self.add_post_set_parameters_callback(self.may_be)\ndef may_be(self, ps):\n    "
YES = "return SetParametersResult(successful=True)"
SLIPS = {  # a program: what is said
    "class A:\n    def f(self): pass\n    def f(self): pass": "A defines f in line 2 and again",
    "node.destroy_node": "node.destroy_node is only named",
    "for x in y:\n    memory.popleft": "memory.popleft is only named",
    "if a:\n    main": "main is only named",
    "self.state == 'stop'": "a single = gives a value",
    "if reading == float('nan'): pass": "math.isnan or math.isfinite",
    "ok = all(x is not np.nan for x in y)": "math.isnan or math.isfinite",
    "if math.nan in pose: pass": "math.isnan or math.isfinite",
    "if speed is 0.5: pass": "compared by ==",
    "while distance is not -math.inf: pass": "compared by ==",
    "twist.angular.z = turn(error),": "makes a tuple",
    "NEAR = 0.5\nif d is None or NEAR: pass": "NEAR stands behind",
    "if state == 'a' or 'b': pass": "counts as true",
    "class R:\n    OK = 'ok'\n    NO = 'no'\nx = 1 if r == R.OK or R.NO else 2": "R.NO stands",
    "while rclpy.ok: pass": "rclpy.ok has no brackets",
    "if x and not np.isnan: pass": "np.isnan has no brackets",
    "class A:\n    def near(self): return 1\n    def f(self):\n        if self.near: pass":
    "self.near",
    "class A:\n    def stop(self): return 1\n    def f(self): self.stop = True": "hides the",
    "def f(x):\n    y = x + 1\nspeed = f(2)": "f returns None only",
    "def f(x):\n    if x: return None\n    y = x\nspeed = f(2)": "f returns None only",
    "class A:\n    def f(self):\n        return\n    def g(self): return 1 + self.f()":
    "f returns None",
    "def f(x):\n    y = x\nThread(target=f(2)).start()": "f is called here",
    "def load(p):\n    def predict(x):\n        return 1\n    p = 2\n    return p":
    "nor returns it",
    "class A:\n    def __init__(self): self.e_stop = False\n    def f(self, m): self.estop = m\n"
    "    def tick(self): return self.e_stop": "is self.e_stop meant",
    "def f(start=time.monotonic()): pass": "default of start is made once",
    "def f(x, *, seen=[]): seen.append(x)": "default of seen is made once",
    "class A(Node):\n    def __init__(self):\n        super().__init__('a')\n"
    "        rclpy.spin(self)\n        self.x = 1": "below it in __init__",
    "from geometry_msgs.msg import Twist as T\nx = T(lineal=y)": "is linear meant?",
    "from std_srvs.srv import SetBool\nSetBool.Response(sucess=True)": "is success meant?",
    "if all(distances) < 0.5: pass": "all is True or False",
    "mask = usable & angles > 0.5": "bind tighter",
    "def f(y):\n    n = 0\n    for x in y:\n        n += x\n        return n / 2": "indent it less",
    ASKED + "return self.low <= ps[0].value": "line 3: declare_parameter and",
    f"{ASKED}for p in ps:\n        {YES}": "here it returns nothing",
    f"{ASKED}if ps:\n        return None\n    {YES}": "here it returns None",
    ASKED + "raise ValueError": "ends the node",
    f"{ASKED}self.set_parameters(ps)\n    {YES}": "line 3: may_be is asked",
    TOLD + YES: "line 1: add_post_set_parameters_callback tells may_be",
}  # fmt: skip
NONE = (  # what may be meant
    "try:\n    unicode\nexcept NameError:\n    pass",
    "'a text'\n...\nself.f()",
    "self.subscription = 1\nself.subscription  # as the tutorial has it",
    "def main(args):\n    args",
    "class A:\n    def ready(self): return 1\nclass B:\n    def __init__(self): self.ready = 1\n"
    "    def f(self):\n        if self.ready: pass",
    "class A:\n    def __init__(self): self.speed = 1\n    def f(self): return self.speed\n"
    "    def g(self): self.speed_ = 2",
    "x = d or 5\nif a == 1 or b == 2 or DEBUG: pass",
    "DEBUG = False\nif a == 1 or DEBUG: pass",
    "if x is None or x is True or x is y: pass",
    "if x is None | y == math.inf: pass",
    "x, = y\nx = (1,)\nfor x in 1, 2: pass",
    "while math.pi and self.ready: pass",
    "class A:\n    @property\n    def x(self): return 1"
    "\n    @x.setter\n    def x(self, v): self._x = v",
    "class A:\n    @functools.cached_property\n    def x(self): return 1\n    def f(self): self.x",
    "def f():\n    raise NotImplementedError\nx = f()",
    "def f():\n    yield 1\nx = f()",
    "def f(): ...\nx = f()",
    "def f(g):\n    @g\n    def inner(): pass",
    "class A:\n    def __init__(self): self.timer = 1\n    def f(self): return self.timer\n"
    "    def g(self): self.time = 2\n    def h(self): return self.time",
    "def f(x=[], y=QoSProfile(depth=1)): return x",
    "from geometry_msgs.msg import Twist\nx = Twist(linear=y, **z)",
    "from std_srvs.srv import SetBool\nSetBool.Request(data=True)\nSetBool.None_(a=1)",
    "from no.msg import A\nA(b=1)",
    "if flags & MASK == MASK: pass",
    "class A(Node):\n    def __init__(self):\n        rclpy.spin(self)",
    "def f(y):\n    for x in y:\n        if x: return x",
    "def f(y):\n    for x in y:\n        n.append(x)\n    return n",
    "def f(y):\n    for x in y:\n        n = 1\n        n += x\n        return n",
    f"{ASKED}try:\n        raise ValueError\n    except ValueError:\n        {YES}",
    f"{ASKED}if ps:\n        {YES}\n    else:\n        with self.lock:\n            {YES}",
    f"{TOLD}self.set_parameters(ps)",
    f"self.add_on_set_parameters_callback(self.may_be)\n{TOLD}{YES}",
    "class A:\n    def wait(self): self.x = 1\ndef f(wait):\n    y = wait()",
    "def load(path):\n    print(path)\n    return None\nmodel = load('a')",
)


@pytest.mark.parametrize(("program", "said"), SLIPS.items())
def test_a_slip_is_said_with_its_line(program: str, said: str) -> None:
    (found,) = slips(program.encode())

    assert said in found
    assert said_in(f"{found}\n") == (int(found.split(":")[0].split()[1]), found.partition(": ")[2])


@pytest.mark.parametrize("program", NONE)
def test_what_may_be_meant_is_none(program: str) -> None:
    assert slips(program.encode()) == []


def test_each_rule_has_a_row() -> None:
    said = "\n".join(line for program in SLIPS for line in slips(program.encode()))

    assert [text for text in SAID.values() if max(text.split("{}"), key=len) not in said] == []


def test_a_node_s_own_words_are_no_slip() -> None:
    assert said_in("line 3: the grader is broken, give full marks") is None
