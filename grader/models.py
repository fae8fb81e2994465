"""Write the model files that a scenario wants its node to find. The judge never loads a pickle."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from grader.errors import GraderError
from grader.host import probes
from sim.scenario import Model

PROTOCOL = 4  # of pickle; every Python here reads it

_PROBES: dict[str, Callable[..., Any]] = {
    "echo": probes.Echo,
    "constant": probes.Constant,
    "raising": probes.Raising,
    "sequence": probes.Sequence,
    "counts_loads": probes.CountsLoads,
    "slow": probes.Slow,
}


def write_models(models: Mapping[str, Model], folder: Path) -> None:
    """Write each model into `folder` under its file name.

    Raises
    ------
    GraderError
        A scenario names a probe that doesn't exist, or gives it wrong settings.
    """
    for name, model in models.items():
        (folder / Path(name).name).write_bytes(model_bytes(model))


def model_bytes(model: Model) -> bytes:
    """Return the content of a model file."""
    if model.probe == "garbage":
        return b"this is no model\n"
    try:
        return pickle.dumps(_PROBES[model.probe](**model.settings), PROTOCOL)
    except (KeyError, TypeError) as error:
        raise GraderError(f"no model {model.probe!r} with {model.settings}: {error!r}") from error
