"""Entry of the fork server, started by the judge only.

python -m grader.host CONTROL_FD EPOCH_NS nodes|scripts|live|tests LAYER,… [LIBRARY …]
"""

from __future__ import annotations

import socket
import sys

from .forkserver import serve

control, epoch, kind, layers, *libraries = sys.argv[1:]
serve(socket.socket(fileno=int(control)), int(epoch), kind, layers.split(","), libraries)
