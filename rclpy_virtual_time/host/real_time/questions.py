"""Questions of a node in real time to the models that the judge keeps."""

from __future__ import annotations

import itertools
import threading

from ..frames import Answers, Asking, Question, Told
from ..wire import Wire


class Desk:
    """Sends questions to the judge and hands its answers to the threads that wait.

    Parameters
    ----------
    wire, lock
        The link, and who may write to it.
    """

    def __init__(self, wire: Wire, lock: threading.Lock) -> None:
        self._wire, self._lock = wire, lock
        self._numbers = itertools.count()
        self._waiting: dict[int, threading.Event] = {}
        self._told: dict[int, Told] = {}
        self._reader: threading.Thread | None = None

    def ask(self, data: bytes) -> bytes:
        """Ask, and wait as long as the answer takes."""
        number, over = next(self._numbers), threading.Event()
        self._waiting[number] = over
        with self._lock:
            if self._reader is None:
                self._reader = threading.Thread(target=self._read, daemon=True)
                self._reader.start()
            self._wire.send(Asking([Question(number, data)]))
        over.wait()
        return self._told.pop(number).data

    def _read(self) -> None:
        while True:
            frame = self._wire.receive()
            if not isinstance(frame, Answers):
                raise ValueError("the judge can only answer")
            for told in frame.told:
                self._told[told.number] = told
                if over := self._waiting.pop(told.number, None):
                    over.set()
