"""The course in a kernel in the browser: `import rclpy_agents_course` lays it there.

It is what the pages' workers have, from the same files; and the notebooks' own room besides.
"""

import gzip
import io
import json
import logging
import sys
import tarfile

from js import XMLHttpRequest, location

COURSE = "/course"
LITE = str(location.href).partition("/extensions/")[0]
WORKSPACE = f"{LITE.rpartition('/')[0]}/_static/workspace/"


def fetched(address: str) -> bytes:
    """Return a file of this site, at once: a worker may wait for it."""
    request = XMLHttpRequest.new()
    request.open("GET", address, False)
    request.responseType = "arraybuffer"
    request.send()
    if request.status != 200:
        raise ImportError(f"{address}: the server answers {request.status}; reload the page")
    return bytes(request.response.to_py())


MANIFEST = json.loads(fetched(f"{WORKSPACE}manifest.json"))
PLAN = json.loads(fetched(f"{WORKSPACE}plan.json?{MANIFEST['plan.json']['sha256']}"))
PARTS = (
    *(f"{WORKSPACE}{name}?{MANIFEST[name]['sha256']}" for name in ("packages.pack", "course.pack")),
    f"{LITE}/static/notebook.pack",
)
for number, address in enumerate(PARTS, 1):
    print(f"\rPython is here, the course is loading: part {number} of 3", end="", flush=True)
    content = io.BytesIO(gzip.decompress(fetched(address)))
    with tarfile.open(fileobj=content) as archive:
        archive.extractall(COURSE, filter="data")
PAGE_PACKAGES = f"{COURSE}/workspace/page_packages"
print(end="\r")
sys.path += [COURSE, PAGE_PACKAGES, f"{PAGE_PACKAGES}/gaps"]  # what the kernel has goes first
logging.getLogger("matplotlib.font_manager").setLevel(logging.ERROR)  # a new list at each start
