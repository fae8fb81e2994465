#!/usr/bin/env bash
# Guess: msgspec's JSON takes and gives back every float, numpy's float64 (a subclass of float) too.
# Seen:  inf and NaN are written as null, without an error, and null is refused where a float is to
#        be read: what was stored can't be loaded. np.float64 is "unsupported", which json of the
#        standard library writes; in MessagePack inf and NaN survive, and np.float64 is refused there,
#        too.
# With:  msgspec 0.22.0, numpy 2.4.6, 2026-11-28
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install msgspec==0.22.0 numpy==2.4.6
"$work/venv/bin/python" - > "$work/seen" <<'PY'
import json
import math

import msgspec
import numpy as np

for value in (math.inf, math.nan):
    text = msgspec.json.encode(value)
    try:
        print(text, msgspec.json.decode(text, type=float))
    except msgspec.ValidationError as error:
        print(text, "refused:", error)
    print(msgspec.msgpack.decode(msgspec.msgpack.encode(value), type=float))
print(json.dumps(np.float64(0.5)))
for form in (msgspec.json, msgspec.msgpack):
    try:
        print(form.encode(np.float64(0.5)))
    except TypeError as error:
        print("refused:", error)
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
b'null' refused: Expected `float`, got `null`
inf
b'null' refused: Expected `float`, got `null`
nan
0.5
refused: Encoding objects of type numpy.float64 is unsupported
refused: Encoding objects of type numpy.float64 is unsupported
SEEN
