"""Entry of the fork server, started by the judge only.

python -m rclpy_virtual_time.host CONTROL_FD EPOCH_NS KIND LAYER,… LANDLOCK ADVICE [LIBRARY …]
"""

from __future__ import annotations

import gc
import socket
import sys

gc.disable()  # imports leave little to collect; `serve` enables it

from .forkserver import serve  # noqa: E402

control, epoch, kind, layers, landlock, advice, *libraries = sys.argv[1:]
judge = socket.socket(fileno=int(control))
serve(judge, int(epoch), kind, layers.split(","), int(landlock), advice, libraries)
