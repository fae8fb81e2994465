"""Start with many command lines and files of parameters, right and wrong; print what came of it."""

import os
import tempfile
from pathlib import Path

import rclpy

HEAD = "/**:\n  ros__parameters:\n"
VALUES = """
1 2.5 -09 09 0x1F 0o17 017 1_000 12:30 1e400 1e-400 9223372036854775808 nan .NaN inf -Inf +.inf
0x1.8p3 5. .5 1e5 1e 1.5f tRue TRUE y ~ null '' '5' '[]' [] [[]] [1,2] [1,2.5] [1,] [y,n] [[1]]
[[1],2] [[1],[2,3]] [a,'b'] {x:1} #c [1 !!str~1 -.5 +0x1f --1 infinity
""".split()  # noqa: SIM905
NAMES = """
a__b _a a_ A __a a.b a. a..b .a a/b /a ~a a-b 1a é par:a.b 1:a /par:a *:a a* {a}
""".split()  # noqa: SIM905
RULES = """
a:=b /a:=b ~/a:=b a/b:=c a/b/:=c a//b:=c {node}/a:=b a:=~/b a:=/b/c a:=b/ a:=~ ~:=b par:a:=b
/par:a:=b 1a:=b a:=1b rostopic://a:=b rosservice:///a:=b foo://a:=b a:=b:=c a=b a:= :=a __ns:=/a
__ns:=/a/b __ns:=a __ns:= __ns:=/a//b par:__ns:=/q __node:=q __node:=/q __node:=q/r __name:=q
other:__node:=q __foo:=b a:=__b a__b:=c a:=b-c *:=/b __ns:=/ a:={node}
""".split()  # noqa: SIM905
LEVELS = """
debug WARN a:=info a.b:=info :=info a:= a:=b:=info 10 warning
""".split()  # noqa: SIM905
FILES = (
    HEAD + "    a: 1\n    l: []\n    s: |-\n      5\n"
    "par:\n  ros__parameters: {a: 2.5, n: {x: 1}}\n",
    HEAD + "    a: &x 1\n    b: *x\n",
    HEAD + "    a:\n",
    HEAD + "    '': 1\n",
    HEAD,
    "",
    "{}\n",
    HEAD + "    a: {}\n",
    HEAD + "    a: !!str 1\n    b: !!float 1\n    c d: 1\n",
    "a: 1\n",
    "- a\n",
    "ns:\n  par:\n    ros__parameters: {a: 2}\npar:\n  ros__parameters: {b: 1}\n",
    "par: {}\n",
    "/par/:\n  ros__parameters: {a: 1}\n",
    "p-r:\n  ros__parameters: {a: 1}\n",
    "par:\n",
    "ros__parameters: {a: 1}\n",
    "par:\n  ros__parameters: {a: 1}\n  x:\n    ros__parameters: {a: 2}\n",
    "par:\n  ros__parameters: {a: 1}\n---\npar:\n  ros__parameters: {b: 1}\n",
    HEAD + "    a: 'x\n",
    "'*':\n  ros__parameters: {a: 1}\n'/**/par':\n  ros__parameters: {b: 1}\n",
    HEAD + "    a.: 1\n",
)


def told(words):
    """Print what a node is told by these words."""
    try:
        rclpy.init(args=["--ros-args", *words])
    except Exception as error:
        said = str(error).partition(", at /")[0].partition("Error:")[0]
        print(words[-1:], type(error).__name__, said.rstrip(". "))
        return
    node = rclpy.create_node("par", allow_undeclared_parameters=True)
    given = {k: (v.type_.name, str(v.value)) for k, v in sorted(node._parameter_overrides.items())}
    topics = [node.resolve_topic_name(word) for word in ("a", "/a", "~/a", "a/b")]
    print(words, given, node.get_fully_qualified_name(), *topics, node.resolve_service_name("a"))
    rclpy.shutdown()


told(["-p", "a:="])
for value in VALUES:
    told(["-p", f"a:={value.replace('~1', ' 1')}"])
for name in NAMES:
    told(["-p", f"{name}:=1"])
for rule in RULES:
    told(["-r", rule])
for level in LEVELS:
    told(["--log-level", level])
for enclave in ("x", "/x/y"):
    told(["--enclave", enclave])
for flag in ("-p", "-r", "--params-file", "-e"):
    told([flag])
os.chdir(tempfile.mkdtemp())
first, second = Path("first.yaml"), Path("second.yaml")
first.write_text(FILES[0], "utf-8")
for words in (
    ["a:=1", "a:=2"], ["a:=1", "a:=2.5"], ["a:=x", "a:=1"], ["a:=[1]", "a:=x"],
    ["a:=[1]", "a:=[2.5]"], ["a:=1", "par:a:=2"], ["par:a:=2", "a:=1"],
):  # fmt: skip
    told([word for one in words for word in ("-p", one)])
for words in (["-p", "a:=9.5"], ["-p", "par:a:=9"], ["-p", "l:=[3]"]):
    for order in ([*words, "--params-file", "first.yaml"], ["--params-file", "first.yaml", *words]):
        told(order)
for text in FILES:
    second.write_text(text, "utf-8")
    told(["--params-file", "second.yaml"])
for ours, own in ((["a:=1"], ["a:=2.5"]), (["par:a:=1"], ["a:=2"]), (["a:=1"], ["par:a:=2"])):
    rclpy.init(args=["--ros-args", "-p", *ours])
    node = rclpy.create_node("par", cli_args=["--ros-args", "-p", *own])
    print(ours, own, {k: v.value for k, v in node._parameter_overrides.items()})
    rclpy.shutdown()
