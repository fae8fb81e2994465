"""The first cell of each notebook, which has to work where the course is not installed yet.

The course comes as a wheel, from a place that the instructor chose, never by a bare name from a
package index, where somebody else could own that name. It is looked for, in this order,

- where the environment variable `COURSE_SOURCE` says: the path of a wheel, an sdist or a checkout,
  or an address such as `https://…` and `git+https://…`,
- at the address that was given to `course release --source`,
- beside the notebook, in the folder above, and among Kaggle's inputs.

If it is nowhere, the cell asks for it. It says in one sentence why it can't go on: a Python of
another age, no network, a package that does not exist for this system. So old versions of Python
have to understand it, too.

- It installs the extras `ros` and `ml`, and matplotlib, but not JupyterLab and nbgrader
  (`notebooks`): a running kernel has its Jupyter already, and a newer version would break it.
- The system Python of Debian and Ubuntu refuses pip. As root, the user of cloud notebooks and
  containers, pip overrides that; anybody else is told to make a venv.
"""

import json
import re

from grader.errors import InputError

SOURCE = 'source = os.environ.get("COURSE_SOURCE") or {address}'
BOOTSTRAP = """\
# Run this cell first, and again after a restart of the kernel. It installs what is missing.
import glob, importlib, importlib.util, os, pathlib, subprocess, sys
class NotReady(Exception):
    def _render_traceback_(self): return ["Not ready: " + str(self)]
if not (importlib.util.find_spec("grader") or importlib.util.find_spec("rclpy_agents_course")):
    source = os.environ.get("COURSE_SOURCE") or ""
    places = [".", "..", "/kaggle/input/*", "/kaggle/input/*/*"]  # of the wheel
    wheels = [w for p in places for w in sorted(glob.glob(p + "/rclpy_agents_course-*.whl"))[-1:]]
    source = source or (wheels or [""])[0]
    if not (3, 11) <= sys.version_info < (3, 15):
        age = "this is Python %d.%d; choose a kernel of Python 3.11 to 3.14."
        raise NotReady(age % sys.version_info[:2])
    if not source:
        raise NotReady("put rclpy_agents_course-….whl, from your instructor, beside this notebook.")
    where = source if "://" in source else pathlib.Path(source).resolve().as_uri()
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--retries=1", "--prefer-binary"]
    is_root = hasattr(os, "getuid") and os.getuid() == 0
    root = {"PIP_BREAK_SYSTEM_PACKAGES": "1", "PIP_ROOT_USER_ACTION": "ignore"} if is_root else {}
    done = subprocess.run(pip + ["rclpy-agents-course[ros,ml] @ " + where, "matplotlib"],
        env=dict(root, **os.environ), stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    said = done.stdout.decode("utf-8", "replace")
    whys = {"No module named pip": "this Python has no pip.",
        "externally-managed": "this Python is the system's; start Jupyter from a venv.",
        "onnection": "pip reaches no network; is the internet switched on here?",
        "No space left": "the disk is full.",
        "No matching dist": "no ready-made package for this system: ",
        "ailed to build": "no ready-made package for this system, and no compiler: "}
    if done.returncode:
        why = next((whys[w] for w in whys if w in said), "pip failed: ")
        last = ([line for line in said.splitlines() if "ERROR" in line] or [said[-300:]])[-1]
        raise NotReady(why + (last if why.endswith(": ") else ""))
    importlib.invalidate_caches()
if not importlib.util.find_spec("grader"):
    import rclpy_agents_course  # the wheel keeps the course's modules together
from grader.notebook import *; prepare()
"""
_ADDRESS = re.compile(r"(https?|git\+https)://[!#-&(-\[\]-~]{1,500}")  # no quotes, no backslash


def with_address(notebook: bytes, address: str) -> bytes:
    """Return a notebook (its JSON) whose first cell gets the course from an address.

    Raises InputError: it is none.
    """
    if not _ADDRESS.fullmatch(address):
        raise InputError(
            f"--source {address!r}: expected the address of the course's wheel, such as "
            "https://university.example/rclpy_agents_course-1.0.0-py3-none-any.whl"
        )
    before, after = (
        json.dumps(SOURCE.format(address=f'"{text}"'))[1:-1].encode() for text in ("", address)
    )
    return notebook.replace(before, after)
