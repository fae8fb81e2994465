"""A rosbag2 bag (MCAP) of what a live robot sent and heard."""

from pathlib import Path
from typing import Any

from sim.bag_qos import profile
from sim.errors import InputError
from sim.messages import typestore


class Recorder:
    """Writes a new bag; it can be read once it is closed.

    Raises InputError: `folder` exists, or cannot be made.

    Parameters
    ----------
    folder
        The bag's folder, which must not exist yet.
    """

    def __init__(self, folder: Path) -> None:
        from rosbags.rosbag2 import StoragePlugin, Writer, WriterError  # noqa: PLC0415  (60 ms)

        self.folder = folder
        self.count = 0  # messages
        self._connections: dict[tuple[str, str], Any] = {}
        try:
            self._writer = Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP)
            self._writer.open()
        except WriterError:
            raise InputError(
                f"{folder}: exists; a bag is never overwritten: choose another place"
            ) from None
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise InputError(f"{folder}: cannot make a bag here: {reason}") from None

    def expect(
        self,
        topic: str,
        type: str,
        *,
        reliable: bool = True,
        latched: bool = False,
        depth: int = 10,
    ) -> None:
        """Prepare for a topic: its first message takes ten milliseconds otherwise.

        The rest is what its publisher offers.
        """
        key = topic, type
        if key not in self._connections:
            self._connections[key] = self._writer.add_connection(
                topic,
                type,
                typestore=typestore(),
                offered_qos_profiles=profile(reliable=reliable, latched=latched, depth=depth),
            )

    def write(self, topic: str, type: str, time: int, data: bytes) -> None:
        """Write a message: CDR bytes, at this ROS time [ns]."""
        self.expect(topic, type)
        self._writer.write(self._connections[topic, type], time, data)
        self.count += 1

    def close(self) -> None:
        """Write what is left, and the bag's index."""
        self._writer.close()
