"""Entry of the fork server, started by the judge only.

python -m rclpy_virtual_time.host CONTROL_FD EPOCH_NS KIND LAYER,… LANDLOCK ADVICE [LIBRARY …]
"""

from __future__ import annotations

import socket
import sys

from .forkserver import serve

control, epoch, kind, layers, landlock, advice, *libraries = sys.argv[1:]
judge = socket.socket(fileno=int(control))
serve(judge, int(epoch), kind, layers.split(","), int(landlock), advice, libraries)
