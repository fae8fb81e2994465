"""What happened in one trial: the one thing that checks and reports see."""

from grader.recording.costs import Costs, account_of, costs_of
from grader.recording.deaths import Death, death_of
from grader.recording.growth import ENDS, ended_of, growth_of, made_again, noted_of, rise_of
from grader.recording.inferences import Inference
from grader.recording.recording import (
    COMPLETED,
    Compute,
    Ending,
    Endpoint,
    Live,
    Outcome,
    Recording,
)
from grader.recording.training import ModelAnswers, ScriptRun, Training
from grader.recording.views import Floats, Goals, Odom, Scan, Twists

__all__ = [
    "COMPLETED",
    "ENDS",
    "Compute",
    "Costs",
    "Death",
    "Ending",
    "Endpoint",
    "Floats",
    "Goals",
    "Inference",
    "Live",
    "ModelAnswers",
    "Odom",
    "Outcome",
    "Recording",
    "Scan",
    "ScriptRun",
    "Training",
    "Twists",
    "account_of",
    "costs_of",
    "death_of",
    "ended_of",
    "growth_of",
    "made_again",
    "noted_of",
    "rise_of",
]
