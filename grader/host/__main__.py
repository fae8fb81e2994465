"""Entry of the nursery: `python -m grader.host CONTROL_FD EPOCH_NS`, started by the judge only."""

from __future__ import annotations

import socket
import sys

from .nursery import serve

serve(socket.socket(fileno=int(sys.argv[1])), int(sys.argv[2]))
