"""The first cell of each notebook. It has to work where the course is not installed yet.

`COURSE_SOURCE` in the environment says where pip gets the course: a wheel, an sdist or a checkout
(a path), or a URL such as `git+https://…`; without it, a package index. Where the course is
installed the cell goes straight to its last two lines.

- The extras are `ros` and `ml`, and matplotlib. JupyterLab and nbgrader (`notebooks`) stay out: a
  machine with a kernel that runs has its Jupyter, and a newer one under its feet would break it.
- Debian's and Ubuntu's own Python refuses pip. As root, which is what the kernels of cloud
  notebooks and containers run as, pip is told to go on; anybody else is told to make a venv.
"""

from __future__ import annotations

BOOTSTRAP = """\
# Run this cell first. It installs what this notebook needs, if that is not there yet.
import importlib, importlib.util, os, pathlib, subprocess, sys
if importlib.util.find_spec("grader") is None:
    course, source = "rclpy-agents-course[ros,ml]", os.environ.get("COURSE_SOURCE")
    if source:  # a file, a folder, or git+https://…
        course += " @ " + (source if "://" in source else pathlib.Path(source).resolve().as_uri())
    root = {"PIP_BREAK_SYSTEM_PACKAGES": "1", "PIP_ROOT_USER_ACTION": "ignore"}
    pip = [sys.executable, "-m", "pip", "install", "--quiet", course, "matplotlib"]
    subprocess.run(pip, check=True, env=(root if os.getuid() == 0 else {}) | os.environ)
    importlib.invalidate_caches()
from grader.notebook import *; prepare()
"""
