"""What rclpy holds of a native thing: it is gone when nobody uses it and its end was asked for."""

from __future__ import annotations

from .errors import InvalidHandle


class Destroyable:
    """The base of all handles."""

    _uses = 0
    _doomed = False
    _gone = False

    @property
    def pointer(self) -> int:
        """A number that no other handle has."""
        return id(self)

    def __enter__(self) -> None:
        if self._doomed:
            raise InvalidHandle("cannot use Destroyable because destruction was requested")
        self._uses += 1

    def __exit__(self, *_: object) -> None:
        self._uses -= 1
        self._end()

    def destroy_when_not_in_use(self) -> None:
        """Destroy it, as soon as nobody is in a `with` of it."""
        self._doomed = True
        self._end()

    def _end(self) -> None:
        if self._doomed and not self._uses and not self._gone:
            self._gone = True
            self._destroy()

    def _destroy(self) -> None:
        """Leave what it belongs to."""
