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
    said: tuple[float, ...] = ()  # for each row of features: [m/s], or the greatest probability
    failed: bool = False  # it raised
    labels: tuple[str, ...] = ()  # for each row, if the model has words for it

    @property
    def is_load(self) -> bool:
        """The model was loaded."""
        return self.method == "load"
