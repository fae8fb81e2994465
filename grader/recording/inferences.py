"""When a node loaded and asked the models that the judge keeps, by the judge's own account.

What passed between a student's nodes and the grader's own server or client, too
(`grader.models.partners`).
"""

from __future__ import annotations

import msgspec


class Inference(msgspec.Struct, frozen=True):
    """A load of a model, a question to a model, or a request of a service."""

    method: str  # load, predict or predict_proba; request or answer
    file: str  # of the model, or the service
    asked: int  # [ns] since the scenario's start; -1: in the node's start-up
    answered: int  # [ns]; later than the recording's end if the answer never came
    took: int  # [ns] of the model's own time
    said: tuple[float, ...] = ()  # for each row of features: [m/s], or the greatest probability
    failed: bool = False  # it raised
    # for each row, if the model has words for it; of a service: the message and its kind
    labels: tuple[str, ...] = ()

    @property
    def is_load(self) -> bool:
        """The model was loaded."""
        return self.method == "load"
