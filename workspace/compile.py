"""Compile Python for the page: `compile.py FOLDER PLACE KEEP LEVEL`, with a Python of its version.

PLACE is where the files will lie. A source whose path matches KEEP stays, beside its code; of any
other only the code is left. LEVEL: 2 leaves out docstrings and asserts.
"""

import importlib.util
import py_compile
import re
import sys
from pathlib import Path

# Read their own docstrings when they start
DOCUMENTED = re.compile("_?pyodide/|numpy/_core/multiarray")
VERSION = (3, 12)  # of Pyodide's Python
folder, place, keep, level = sys.argv[1:]
if sys.version_info[:2] != VERSION:
    sys.exit(f"expected Python {VERSION[0]}.{VERSION[1]}, got {sys.version}")
for source in sorted(Path(folder).rglob("*.py")):
    name = source.relative_to(folder).as_posix()
    stays = re.search(keep, name)
    target = importlib.util.cache_from_source(str(source)) if stays else f"{source}c"
    unchecked = py_compile.PycInvalidationMode.UNCHECKED_HASH
    strip = 0 if DOCUMENTED.match(name) else int(level)
    py_compile.compile(str(source), target, f"{place}/{name}", True, strip, unchecked)
    if not stays:
        source.unlink()
