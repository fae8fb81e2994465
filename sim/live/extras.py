"""What runs beside the robot on request: a bag, a viewer."""

from contextlib import ExitStack
from dataclasses import dataclass

from sim.live.options import Options
from sim.live.recorder import Recorder
from sim.live.viewer import Viewer


@dataclass(frozen=True)
class Extras:
    """The bag and the viewer, where they were asked for."""

    recorder: Recorder | None = None
    viewer: Viewer | None = None

    def record(self, topic: str, type: str, time: int, data: bytes) -> None:
        """Record a message that was sent or heard: CDR bytes, at this ROS time [ns]."""
        if self.recorder:
            self.recorder.write(topic, type, time, data)


def open_extras(options: Options, name: str, life: ExitStack) -> Extras:
    """Return what the options ask for; it is closed with `life`.

    Raises InputError: the bag cannot be made, or the viewer cannot serve.
    """
    recorder = viewer = None
    if options.record is not None:
        recorder = Recorder(options.record)
        life.callback(recorder.close)
    if options.foxglove is not None:
        viewer = Viewer(name, options.foxglove)
        life.callback(viewer.close)
    return Extras(recorder, viewer)
