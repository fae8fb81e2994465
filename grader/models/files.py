"""Write the model files that a scenario gives its node. The judge never loads a pickle."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from grader.errors import GraderError
from grader.hosted.supplied import classifiers, probes
from grader.hosted.supplied.kept import Kept, KeptClassifier
from grader.models.exporter import EXPORTER
from sim.scenario import Model

OWN = "own"  # the student's own trained model
PICKLE = ".pkl"
EXPORTED = (".onnx", ".pt2", ".keras")  # suffixes of formats that need other libraries
LEARNED = ("linear", "tree", "trained")  # scikit-learn's own models, if in a pickle
GROWN = ("tree", "trained")  # of these, what scikit-learn fits, whatever the format
RAW = ("garbage", "empty", "foreign", "pickled")  # written here, whatever the format
WRITTEN_BY = {".pkl": ("sklearn",), ".onnx": ("onnx",), ".pt2": ("torch",),
              ".keras": ("torch", "keras")}  # fmt: skip
PROTOCOL = 4  # of pickle; every Python here reads it
_FOREIGN = b"cmy_training_script\nMyModel\n."  # a pickle whose class was in a script, now missing


def _linear(weights: tuple[float, ...], offset: float = 0.0, **_form: Any) -> probes.Weighted:
    """Return the linear model, whatever the format of its file."""
    return probes.Weighted(weights, offset)


_PROBES: dict[str, Callable[..., Any]] = {
    "echo": probes.Echo,
    "constant": probes.Constant,
    "by_distance": probes.ByDistance,
    "raises_near": probes.RaisesNear,
    "counts_loads": probes.CountsLoads,
    "slow": probes.Echo,
    "weighted": probes.Weighted,
    "linear": _linear,
    "describes": classifiers.Describes,
    "numbers": classifiers.Numbers,
    "counts_loads_in_label": classifiers.CountsLoads,
    "fails_at": classifiers.FailsAt,
}


def write_models(models: Mapping[str, Model], folder: Path) -> None:
    """Write each model into `folder` under its name, which may be that of a file in a folder.

    Its format is that of the suffix, or of the suffix in its setting `format`.

    Raises GraderError: a scenario names an unknown probe, or gives it wrong settings.
    """
    for name, model in models.items():
        if model.probe == OWN:  # comes from the student's training script, if it made one
            continue
        path = _within(folder, name)
        if is_kept(name, model):
            path.write_bytes(_kept_bytes(name, model))
        else:
            path.write_bytes(model_bytes(model, _format(name, model)))


def needed_for(models: Mapping[str, Model]) -> Iterator[str]:
    """Yield the modules without which these models can't be written."""
    for name, model in models.items():
        if model.probe in (OWN, *RAW) or is_kept(name, model):
            continue
        format = _format(name, model)
        if format in EXPORTED or model.probe in LEARNED:
            yield from WRITTEN_BY[format if format in EXPORTED else PICKLE]
        if model.probe in GROWN:
            yield "sklearn"


def _format(name: str, model: Model) -> str:
    return str(model.settings.get("format", Path(name).suffix.lower()))


def _within(folder: Path, name: str) -> Path:
    """Return where the model of this name goes."""
    path = folder / name
    if ".." in path.parts or folder not in path.parents:
        raise GraderError(f"a model named {name!r} would not lie in the node's working folder")
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def is_kept(name: str, model: Model) -> bool:
    """Return whether the model of this file stays with the judge, as every probe in a pickle does.

    The file does not contain the model; it can only be queried.
    """
    known = model.probe in _PROBES and model.probe not in LEARNED
    return known and Path(name).suffix.lower() == PICKLE


def _kept_bytes(name: str, model: Model) -> bytes:
    """Return a pickle whose model queries the judge."""
    kind = KeptClassifier if hasattr(probe(model), "predict_proba") else Kept
    return pickle.dumps(kind(name), PROTOCOL)


def model_bytes(model: Model, suffix: str = PICKLE) -> bytes:
    """Return the content of a model file, in the format of the (lower-case) suffix."""
    if model.probe == "garbage":
        return b"this is no model\n"
    if model.probe == "empty":
        return b""
    if model.probe == "foreign":
        return _FOREIGN
    if model.probe == "pickled":  # a model, but not in the format of the file's suffix
        return pickle.dumps(probes.Constant(0.3), PROTOCOL)
    if suffix in EXPORTED or model.probe in LEARNED:
        return EXPORTER.content(suffix, model.probe, model.settings)
    return pickle.dumps(probe(model), PROTOCOL)


def probe(model: Model) -> Any:
    """Return the probe model itself, from which checks get its answer to a scan.

    Raises GraderError: there is no such probe, or its settings are wrong.
    """
    try:
        return _PROBES[model.probe](**model.settings)
    except (KeyError, TypeError) as error:
        raise GraderError(f"no model {model.probe!r} with {model.settings}: {error!r}") from error
