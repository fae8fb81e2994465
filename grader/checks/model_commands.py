"""The words of the checks about a node that drives as a model says.

    predicts    the command is what the model says, clipped
    stands      0.0 for every scan, and an error in the log
    loads_once  one load, before the first scan

What is right stands in `model_cases`.
"""

from __future__ import annotations

import math
from functools import partial

from grader.checks.ahead import front_distance
from grader.checks.case import Case, Runs
from grader.checks.inferences import loads
from grader.checks.model_cases import CALLED, PREDICT
from grader.checks.predictions import model_file
from grader.checks.verdict import fail
from grader.checks.words import TOLERANCE, follows, logs
from grader.recording import Recording, Scan

ERRORS = ("error", "fatal")
SILENTLY = "A robot that silently stands still costs an afternoon: log which file is the cause."
FREE = 1.2  # [m] ahead
HALF_A_CENTIMETRE = 0.005 + 1e-9  # [m/s] what rounding to two decimals changes at most


def predicts(runs: Runs, *tags: str, help: str = "", tolerance: float = TOLERANCE) -> None:
    """Fail unless the node commands what its model says, clipped, on each occasion of these tags.

    What it commands may be off by `tolerance` [m/s]. Each tag has to occur in each run.
    """
    for recording in runs:
        run = runs.of([recording])
        explain = partial(_explain, recording)
        follows(run, *tags, help=help, tolerance=tolerance, explain=explain)


def stands(runs: Runs, help: str = "A broken file can raise any exception.") -> None:
    """Fail unless the node commands 0.0 for every scan, as without a model, and logs an error."""
    follows(runs, help=help)
    for recording in runs:
        file = model_file(recording.scenario)
        logs(recording, ERRORS, what=f"there is no model to load from {file}", help=SILENTLY)


def loads_once(runs: Runs) -> None:
    """Fail unless the judge's model was loaded once, before the first scan came."""
    for recording in runs:
        times = [load.asked / 1e9 for load in loads(recording)]
        first = float(recording.times("/scan").min(initial=recording.duration_s))
        late = [t for t in times if t >= first]
        if len(times) == 1 and not late:
            continue
        fail(
            f"the model was loaded at {late[0]:.2f} s, when scans had come"
            if late
            else f"the model was loaded {len(times)} times before the first scan",
            expected="1 load, while the node is constructed",
            actual=f"{len(times)} loads",
            at=(late or [first])[0],
            recording=recording,
            help="Load in __init__, keep the model in an attribute, and use that one in the "
            "callback, also after it has raised.",
        )


def started(recording: Recording) -> str:
    """Return in words with which parameters the node was started."""
    given = (f"{k}:={v}" for k, v in recording.scenario.node.parameters.items())
    return f"Started with {' and '.join(given) or 'the defaults, velocity_model.pkl and 0.5'}"


def is_free(scan: Scan) -> bool:
    """Return whether the way is so free that every model trained on the course's data drives."""
    distance = front_distance(scan)
    return distance is not None and distance >= FREE


def _explain(recording: Recording, case: Case) -> str:
    """Return what else is known of a wrong command: an error in the log, no question, rounding."""
    times = recording.times("/scan")
    first, later = times.min(initial=math.inf), times[times > case.at].min(initial=math.inf)
    for line in reversed(recording.log):
        if line.level in ERRORS and (case.at <= line.t < later or line.t < first):
            return f"The node's log says: {line.text.strip()[:300]}"
    if case.said.get(PREDICT, CALLED) != CALLED:
        return "Ask the model about the features of each scan, and publish what it says."
    if not case.wrong(HALF_A_CENTIMETRE):
        return "Is something rounded, filtered or averaged? Publish what predict returns, clipped."
    return ""
