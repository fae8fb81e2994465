"""What goes beside the robot if somebody asks for it: a bag, a viewer."""

from contextlib import ExitStack
from dataclasses import dataclass

from sim.live.options import Options
from sim.live.recorder import Recorder
from sim.live.viewer import Viewer


@dataclass(frozen=True)
class Extras:
    """What was asked for."""

    recorder: Recorder | None = None
    viewer: Viewer | None = None

    def record(self, topic: str, type: str, time: int, data: bytes) -> None:
        """Note a message that was sent or heard: CDR bytes, of this ROS time [ns]."""
        if self.recorder:
            self.recorder.write(topic, type, time, data)


def open_extras(options: Options, name: str, life: ExitStack) -> Extras:
    """Return what the options ask for; it is closed with `life`.

    Raises
    ------
    InputError
        The bag can't be made, or the viewer can't serve.
    """
    recorder = viewer = None
    if options.record is not None:
        recorder = Recorder(options.record)
        life.callback(recorder.close)
    if options.foxglove is not None:
        viewer = Viewer(name, options.foxglove)
        life.callback(viewer.close)
    return Extras(recorder, viewer)
