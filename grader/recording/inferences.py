"""When a node loaded and asked the models that the judge keeps, by the judge's own account."""

from __future__ import annotations

import msgspec


class Inference(msgspec.Struct, frozen=True):
    """One load of a model, or one question to it."""

    method: str  # load, predict or predict_proba
    file: str  # of the model
    asked: int  # [ns] since the scenario's start; -1: in the node's start-up
    answered: int  # [ns]; later than the recording's end if the answer never came
    took: int  # [ns] of the model's own time
    said: tuple[float, ...] = ()  # predictions [m/s], one for each row of features
    failed: bool = False  # it raised

    @property
    def is_load(self) -> bool:
        """The model was loaded."""
        return self.method == "load"
