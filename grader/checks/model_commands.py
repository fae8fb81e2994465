"""The words of the checks about a node that drives as a model says (`predictions`)."""

from __future__ import annotations

import math
from functools import partial

from grader.checks.case import Case, Runs
from grader.checks.contract import free_from
from grader.checks.predictions import CALLED, OTHERWISE, PREDICT, loads, model_file
from grader.checks.verbs import TOLERANCE, answers_once, follows, keeps_distance, logs
from grader.checks.verdict import fail
from grader.recording import Recording

ERRORS = ("error", "fatal")
HELP = {  # by tag
    "blind": "Do not ask the model about a scan with a blind sector: command 0.0 and log why.",
    "clip": "min(max(speed, 0.0), max_speed)",
    "not_finite": "min and max do not stop NaN, and clip +inf: ask math.isfinite first.",
    "raises": "try: … except Exception as error: around the prediction, and publish 0.0.",
}
SILENTLY = "A robot that silently stands still costs an afternoon: log which file is the cause."
FREE = free_from(1.2)  # then every model trained on the course's data drives
HALF_A_CENTIMETRE = 0.005 + 1e-9  # [m/s] what rounding to two decimals changes at most


def predicts(runs: Runs, *tags: str, help: str = "", tolerance: float = TOLERANCE) -> None:
    """Fail unless the node commands its model's answer, clipped, in each case with these tags.

    A command may be off by `tolerance` [m/s]. Each tag has to occur in each run.
    """
    help = help or " ".join(HELP[tag] for tag in tags if tag in HELP)
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
        if len(times) != 1 or late:
            fail(
                f"the model was loaded {len(times)} times, {len(late)} of them when scans had come",
                expected="1 load, while the node is constructed",
                actual=f"{len(times)} loads",
                at=(late or [first])[0],
                recording=recording,
                help="Load in __init__, keep the model in an attribute, and use that one in the "
                "callback, also after it has raised.",
            )


def keeps_contract(runs: Runs, help: str, tolerance: float = TOLERANCE) -> None:
    """Fail unless each scan is answered, by what the model says; and no drive ends in a contact."""
    answers_once(runs)
    predicts(runs.benches(), help=help, tolerance=tolerance)
    keeps_distance(runs.driven(), 0.0)


def obeys_parameters(runs: Runs, help: str, tolerance: float = TOLERANCE) -> None:
    """Fail unless the node predicts with the parameters with which it was started."""
    for recording in runs:
        parameters = recording.scenario.node.parameters.items()
        given = " and ".join(f"{name}:={value}" for name, value in parameters) or "the defaults"
        help_with_given = f"Started with {given}. {help}"
        predicts(runs.of([recording]), help=help_with_given, tolerance=tolerance)


def _explain(recording: Recording, case: Case) -> str:
    """Return what explains a wrong command: an error in the log, no question, rounding."""
    times = recording.times("/scan")
    first, later = times.min(initial=math.inf), times[times > case.at].min(initial=math.inf)
    for line in reversed(recording.log):
        if line.level in ERRORS and (case.at <= line.t < later or line.t < first):
            return f"The node's log says: {line.text.strip()[:300]}"
    if case.said.get(PREDICT) == OTHERWISE:
        return "The model was asked, but about other features than this scan has: log all five."
    if case.said.get(PREDICT, CALLED) != CALLED:
        return "Ask the model about the features of each scan, and publish what it says."
    if not case.wrong(HALF_A_CENTIMETRE):
        return "Is something rounded, filtered or averaged? Publish what predict returns, clipped."
    return ""
