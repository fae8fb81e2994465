"""A program has what it imports, as on a robot, whatever its host has imported before it."""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

from rclpy_portable import unpacking
from rclpy_virtual_time.host.frames import Ended, ProgramStart, Start
from rclpy_virtual_time.link.hosts import ForkServer
from rclpy_virtual_time.link.practice import PracticeServer
from rclpy_virtual_time.link.settings import EPOCH

LIMIT = 60.0  # [s]
LEARNING = ("sklearn.ensemble", "onnxruntime") if find_spec("sklearn") else ()
ADVICE = "rclpy_virtual_time.tests.host.hiding:Hiding"
LINES = {
    "only rclpy": "import rclpy",
    "a node": """
        import concurrent, email, http, importlib, json, logging, unittest, urllib, xml
        import geometry_msgs, sensor_msgs, std_srvs, rcl_interfaces, action_msgs
        import asyncio, os, threading, time, ctypes, uuid, rclpy.action, rclpy.executors
        import concurrent.futures, numpy as np
        from rclpy.node import Node
        from sensor_msgs.msg import LaserScan
        pool = concurrent.futures.ThreadPoolExecutor
    """,
    "learning": "import sklearn, onnxruntime",
}
REACHED = """
import json, sys, types
lazy = {*'__annotations__ AsyncContextManager ContextManager ForwardRef Match Pattern'.split()}
def reached():
    found, waiting = {}, [sys.modules['__main__']]
    while waiting:
        module = waiting.pop()
        if module.__name__ not in found:
            found[module.__name__] = sorted(vars(module).keys() - lazy)  # made when asked for
            waiting += [v for v in vars(module).values() if isinstance(v, types.ModuleType)]
            classes = [v for v in vars(module).values() if isinstance(v, type)]
            found |= {f'{c.__module__}:{c.__qualname__}': sorted(vars(c).keys() - lazy)
                      for c in classes}
    return {name: names for name, names in found.items() if not name.startswith('__main__')}
"""
# What a program can reach here and not on plain Python, or the other way round, and why.
REVIEWED = {
    # What waits does so in virtual time, and is written in Python.
    "_queue:SimpleQueue lacks it",
    "_thread:RLock lacks it",
    "_thread:lock has __dict__ __init__ __weakref__ kernel",
    "_thread:lock has __dict__ __init__ __static_attributes__ __weakref__ kernel",
    "_thread:lock lacks __new__",  # from Python 3.13 on, as the line before
    "joblib.externals.loky.backend.resource_tracker:LokyRLock lacks __dict__",  # its base has one
    "rclpy_virtual_time.host.virtual.descriptors:_polling.<locals>.Polling has it",
    "select:epoll lacks it",
    "selectors:PollSelector has select",
    "abc:PopenSelector has it",  # subprocess takes PollSelector where there is select.poll
    "rclpy._rclpy_pybind11:EventsExecutor lacks it",  # it sends the node to real time
}


def dedent(lines: str) -> str:
    return "\n".join(line.strip() for line in lines.strip().splitlines()) + "\n"


@pytest.fixture(scope="module", params=["real", "portable"])
def learned(request: pytest.FixtureRequest) -> Iterator[ForkServer | PracticeServer]:
    """Hosts that have imported libraries of models."""
    libraries = LEARNING if request.param != "portable, bare" else ()
    server = ForkServer if request.param == "real" else PracticeServer
    with server(EPOCH, libraries=libraries, advice=ADVICE) as started:
        yield started


# What every host has imported is enough there: each does it anew
WARM = pytest.mark.parametrize("learned", ["real", "portable, bare"], indirect=True)


@pytest.fixture
def folder() -> Iterator[Path]:
    """Return a folder that another user can enter."""
    with tempfile.TemporaryDirectory() as made:
        yield Path(made)


def end_of(server: ForkServer | PracticeServer, file: Path) -> tuple[str, list[str]]:
    """Return how a program ended that never waits, and what it printed."""
    with server.host(file.parent) as link:
        start = Start((ProgramStart(str(file)),), EPOCH, seed=1, offers=())
        ended, _ = link.run(start, LIMIT)
        assert isinstance(ended, Ended), ended
        return f"{ended.kind}: {ended.text}", [line.text for line in link.log()]


def on_plain_python(server: ForkServer | PracticeServer, file: Path) -> str:
    """Return what a program prints without a host; the last line of stderr if it dies."""
    path = [str(unpacking.folder(print)), str(Path(unpacking.__file__).parents[1])]
    portable = {"PYTHONPATH": os.pathsep.join(path)} if isinstance(server, PracticeServer) else {}
    done = subprocess.run(
        [sys.executable, "-B", str(file)],
        capture_output=True, text=True, check=False, cwd="/", env={**os.environ, **portable},
    )  # fmt: skip
    return done.stdout if done.returncode == 0 else done.stderr.strip().splitlines()[-1]


@WARM
def test_a_program_that_imports_datetime_alone_reads_virtual_time(
    learned: ForkServer | PracticeServer, folder: Path
) -> None:
    file = folder / "node.py"
    file.write_text("from datetime import datetime\nprint(datetime.now(), datetime.utcnow())\n")
    ended, said = end_of(learned, file)
    *warned, printed = said
    assert printed.count("2023-11-14 22:13:") == 2, (ended, said)
    assert bool(warned) == (sys.version_info >= (3, 12))
    assert not warned or f"{file}:2: DeprecationWarning: datetime.datetime.utcnow" in warned[0]


@WARM
def test_nothing_is_left_beside_a_program(
    learned: ForkServer | PracticeServer, folder: Path
) -> None:
    file = folder / "node.py"
    file.write_text("import os\nprint(*os.listdir(os.path.dirname(__file__)))\nimport helper\n" * 2)
    (folder / "helper.py").touch()
    first, then = end_of(learned, file)[1]
    assert first == then
    assert "helper.py" in first


@pytest.mark.parametrize(
    "lines",
    [
        pytest.param(lines, id=name, marks=() if name == "a node" else pytest.mark.long)
        for name, lines in LINES.items()
    ],
)
def test_the_names_that_a_program_reaches_are_those_of_plain_python(
    learned: ForkServer | PracticeServer, folder: Path, lines: str
) -> None:
    if "sklearn" in lines:
        pytest.importorskip("sklearn")
        pytest.importorskip("onnxruntime")
    file = folder / "node.py"
    file.write_text(dedent(lines) + REACHED + "print(json.dumps(reached()))")
    plain = json.loads(on_plain_python(learned, file).splitlines()[-1])
    file.write_text(
        dedent(lines) + REACHED + f"plain, here = json.loads({json.dumps(plain)!r}), reached()\n"
        "for name in sorted(plain.keys() | here.keys()):\n"
        "    if name not in here: print(name, 'lacks it')\n"
        "    elif name not in plain: print(name, 'has it')\n"
        "    else:\n"
        "        more = sorted({*here[name]} - {*plain[name]})\n"
        "        less = sorted({*plain[name]} - {*here[name]})\n"
        "        if more: print(name, 'has', *more)\n"
        "        if less: print(name, 'lacks', *less)\n"
    )
    ended, said = end_of(learned, file)
    assert ended == "returned: the program ran to its end and made no node"
    assert set(said) <= REVIEWED


BESIDE = {  # a file beside the node: how the node ends
    "rclpy.py": "ModuleNotFoundError: No module named 'rclpy.node'; 'rclpy' is not a package",
    "rclpy/__init__.py": "ModuleNotFoundError: No module named 'rclpy.node'",
    "string.py": "ImportError: cannot import name 'Template' from 'string'",  # rclpy has logging
    "logging.py": "AttributeError: module 'logging' has no attribute 'getLogger'",
    "math.py": "AttributeError: module 'math' has no attribute 'floor'",  # in numpy's C
    "array.py": "AttributeError: module 'array' has no attribute 'array'",  # when a node is made
    "numpy.py": "ran 1",
    "platform.py": "ran 1",  # numpy has it, too
    "copy.py": "ran 1",  # nothing misses what it lacks
    "time.py": "ran None",  # Python's own is built in; so are math and array in some builds
}
NODE = """
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
import {}
rclpy.init(); Node('n')
print('ran', getattr({}, 'LEVEL', None))
"""


@pytest.mark.parametrize(
    "learned", ["real", pytest.param("portable, bare", marks=pytest.mark.long)], indirect=True
)
@pytest.mark.parametrize("name", BESIDE)
def test_a_file_beside_the_node_goes_first(
    learned: ForkServer | PracticeServer, folder: Path, name: str
) -> None:
    (folder / name).parent.mkdir(exist_ok=True)
    (folder / name).write_text("LEVEL = 1\n")
    if name == "math.py" and isinstance(learned, PracticeServer):
        pytest.skip("the portable rclpy dies of it, too, but says more")
    module = name.removesuffix(".py").removesuffix("/__init__")
    file = folder / "node.py"
    file.write_text(NODE.format(module, module))
    plain = on_plain_python(learned, file)
    ended, said = end_of(learned, file)
    meant = "ran None" if module in sys.builtin_module_names else BESIDE[name]
    assert plain.startswith(meant)
    if meant.startswith("ran"):
        assert said == [meant]
        return
    assert plain.partition(" (")[0] in ended  # without the path
    assert ended.endswith(f"hidden by {folder / name}"), ended


@WARM
def test_a_node_named_like_what_it_imports_is_told_so(
    learned: ForkServer | PracticeServer, folder: Path
) -> None:
    (folder / "rclpy.py").write_text(NODE.format("time", "time"))
    ended, _ = end_of(learned, folder / "rclpy.py")
    assert ended.endswith(f"hidden by {folder / 'rclpy.py'}"), ended


@pytest.mark.skipif(not LEARNING, reason="no library is installed of which a host has much")
@pytest.mark.parametrize("learned", ["real"], indirect=True)
def test_libraries_are_set_aside_before_a_host_is_forked(learned: ForkServer, folder: Path) -> None:
    """Linux copies hardly more pages for a host of them than for one without."""
    file = folder / "node.py"
    file.write_text("print(open('/proc/self/smaps_rollup').read().split('Private_Dirty:')[1][:20])")
    with ForkServer(EPOCH, advice=ADVICE) as bare:
        written, more = (int(end_of(each, file)[1][0].split()[0]) for each in (bare, learned))
    assert more < written + 2500  # [kB]; 4,400 where each host sets them aside
