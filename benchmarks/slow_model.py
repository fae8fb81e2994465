"""A model of 200 ms under a control rate of 20 Hz: in virtual time and live, side by side.

Runs solutions of exercise 5, right and wrong ones, in its scenario `slow_leader` and prints how
often each published and its longest silence. Both figures come from the same recordings that the
checks read.
"""

from __future__ import annotations

import argparse

import msgspec
import numpy as np

from grader.authoring.claims import claims, complete
from grader.course.exercises import find_exercise
from grader.link.hosts import ForkServer
from grader.recording import Recording
from grader.trial.real_time import run_live_trial
from grader.trial.virtual_time import run_trial
from sim.messages import EPOCH_NS
from sim.scenario_files import load_scenario

EXERCISE = "slow_model"
SCENARIO = "slow_leader"
SETTLED = 2.0  # [s] from here on the rate counts
SHOWN = {
    "decoupled_controller": "reference: the model in a group of its own",
    "groups_and_two_timers": "three callback groups, inference by a timer",
    "worker_thread_queue": "a worker thread",
    "one_group_for_all": "MultiThreadedExecutor, but one group for all",
    "model_in_the_scan_callback": "model in the scan callback, one thread",
    "model_in_the_timer": "model in the control timer, one thread",
}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=12.0, help="of each run")
    options = parser.parse_args()
    scenario = msgspec.structs.replace(load_scenario(SCENARIO), duration=options.seconds)
    exercise = find_exercise(EXERCISE)
    found = {claim.stem: claim for claim in claims(exercise) if claim.kind != "skeleton"}
    print(f"{'':46}   virtual time       live\n{'':46}   Hz   longest    Hz   longest")
    with ForkServer(EPOCH_NS, libraries=exercise.libraries) as forkserver:
        for stem, about in SHOWN.items():
            with complete(found[stem]) as submission:
                virtual = run_trial(submission, scenario, forkserver)
                live = run_live_trial(submission, scenario, forkserver)
            stalled = f"  ({live.live.stall})" if live.live and live.live.stall else ""
            print(f"{about:46} {_figures(virtual)}  {_figures(live)}{stalled}", flush=True)


def _figures(recording: Recording) -> str:
    """Return commands per second, and the longest time between two [ms]."""
    times = recording.twists().t
    gaps = np.diff(times[times >= SETTLED])
    if not len(gaps):
        return f"{recording.outcome.kind:>14}"
    return f"{1 / gaps.mean():4.1f} {1e3 * gaps.max():5.0f} ms"


if __name__ == "__main__":
    main()
