"""What rclpy_virtual_time.host.virtual.clock uses of time_machine: another clock under `datetime`.

time_machine puts it there in C; this is a subclass, which a module has that imports `datetime`
from now on.
"""

import datetime as _datetime
from typing import Any


class _Traveller:
    """Tells the time since 1970 by `time_ns`, which is replaced."""

    def time_ns(self) -> int:
        return 0

    def start(self) -> "_Traveller":
        traveller, real = self, _datetime.datetime

        class datetime(real):  # type: ignore[valid-type, misc]
            @classmethod
            def now(cls, tz: Any = None) -> Any:
                return cls.fromtimestamp(traveller.time_ns() // 1000 / 1e6, tz)

            @classmethod
            def utcnow(cls) -> Any:
                return cls.now(_datetime.UTC).replace(tzinfo=None)

            @classmethod
            def today(cls) -> Any:
                return cls.now()

        _datetime.datetime = datetime  # type: ignore[misc]
        return self


def travel(destination: int, tick: bool = True) -> _Traveller:
    """Return what `start` begins."""
    return _Traveller()
