"""Starts the robot with one wrong command line after another; prints for each what came of it.

wrong_values.py JSON, a list of command lines.
"""

import contextlib
import io
import json
import sys
import traceback

from sim.live.cli import main

for line in json.loads(sys.argv[1]):
    said = io.StringIO()
    code = -1
    with contextlib.redirect_stderr(said):
        try:
            code = main(line.split())
        except BaseException:
            traceback.print_exc()
    print(json.dumps({"topic": line, "code": code, "said": said.getvalue()}), flush=True)
