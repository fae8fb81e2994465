"""What a training script made: the part of a recording that a `[training]` scenario has."""

from __future__ import annotations

import msgspec
import numpy as np
from numpy.typing import NDArray

from grader.hosted.models import Tensor

Floats = NDArray[np.float64]


class ScriptRun(msgspec.Struct, frozen=True):
    """One run of a training script."""

    kind: str  # returned, exited, exception, syntax_error, died, hung, forged
    text: str  # one line for the student
    detail: str  # a traceback
    wall: float  # [s]
    files: dict[str, int]  # what it was to write: size [bytes]; missing if it wrote none

    @property
    def succeeded(self) -> bool:
        """The script came to its end without an error."""
        return self.kind == "returned" or self.text in ("sys.exit()", "sys.exit(0)")


class ModelAnswers(msgspec.Struct, frozen=True):
    """What one trained model said about the hidden scans."""

    problem: str = ""  # why it could not be loaded, or what predict raised
    loaded: bool = False
    shape: tuple[int, ...] = ()
    values: bytes = b""  # float64 [m/s]

    @property
    def speeds(self) -> Floats:
        """(n,) predictions [m/s]."""
        return np.frombuffer(self.values[: len(self.values) // 8 * 8])


class Training(msgspec.Struct, frozen=True):
    """What a training script made; the part of a recording that a `[training]` scenario has."""

    script: str
    problem: str = ""  # why it was not run at all
    runs: tuple[ScriptRun, ...] = ()  # as the robot's lidar recorded it; again, other files' names
    plain: ScriptRun | None = None  # on finite numbers, if the first run ended with an error
    pickle: ModelAnswers = ModelAnswers()
    again: ModelAnswers = ModelAnswers()  # the second run's
    onnx: ModelAnswers = ModelAnswers()
    converted: ModelAnswers = ModelAnswers()  # where `onnx` is not as the pickle: as ONNX by us
    onnx_inputs: tuple[Tensor, ...] = ()
    onnx_outputs: tuple[Tensor, ...] = ()
    labels: bytes = b""  # float64, the expert's speeds [m/s]
    single_wall: bytes = b""  # float64, of predictions for one scan each [s]
    single_cpu: bytes = b""

    @property
    def made(self) -> ScriptRun:
        """The run that wrote the models, if any did."""
        return self.plain if self.plain is not None and self.plain.succeeded else self.runs[0]

    @property
    def expert(self) -> Floats:
        """(n,) speeds that the expert chose for the hidden scans [m/s]."""
        return np.frombuffer(self.labels)
