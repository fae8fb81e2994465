"""The first cell of each notebook, which has to work where the course is not installed yet.

The environment variable `COURSE_SOURCE` says where pip gets the course: the path of a wheel, an
sdist or a checkout, or a URL such as `git+https://…`; without it, a package index. If the course is
installed, the cell goes straight to its last lines.

- It installs the extras `ros` and `ml`, and matplotlib, but not JupyterLab and nbgrader
  (`notebooks`): a running kernel has its Jupyter already, and a newer version would break it.
- The system Python of Debian and Ubuntu refuses pip. As root, the user of cloud notebooks and
  containers, pip overrides that; anybody else is told to make a venv.
"""

from __future__ import annotations

BOOTSTRAP = """\
# Run this cell first. It installs what this notebook needs, if that is not there yet.
import importlib, importlib.util, os, pathlib, subprocess, sys
if not (importlib.util.find_spec("grader") or importlib.util.find_spec("rclpy_agents_course")):
    course, source = "rclpy-agents-course[ros,ml]", os.environ.get("COURSE_SOURCE")
    if source:  # a file, a folder, or git+https://…
        course += " @ " + (source if "://" in source else pathlib.Path(source).resolve().as_uri())
    root = {"PIP_BREAK_SYSTEM_PACKAGES": "1", "PIP_ROOT_USER_ACTION": "ignore"}
    pip = [sys.executable, "-m", "pip", "install", "--quiet", course, "matplotlib"]
    is_root = hasattr(os, "getuid") and os.getuid() == 0
    subprocess.run(pip, check=True, env=(root if is_root else {}) | os.environ)
    importlib.invalidate_caches()
if not importlib.util.find_spec("grader"):
    import rclpy_agents_course  # the wheel keeps the course's modules together
from grader.notebook import *; prepare()
"""
