"""The core checks of exercise 7; they sum to 100 points."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.check import DECISION, SAFETY, TIMING, WIRING, check
from grader.checks.commands import FIELDS, ZERO
from grader.checks.verbs import follows, keeps_distance, wired, within, zero
from grader.exercises.safety_supervisor.contract import CONTRACT, DIAGNOSTICS_TOPIC, LEVELS
from grader.exercises.safety_supervisor.words import heeds, one_a_tick, own_reason, reports_often

SHORT = (
    "safe_pass", "safe_limits", "safe_ramp", "safe_e_stop", "safe_stale_command",
    "safe_obstacle", "safe_stale_scan",
)  # fmt: skip
EVERY = (*SHORT, "safe_bad_command", "safe_blind")
BUTTON = "safe_button"  # at the same time as other reasons
LONG = "safe_for_long"  # half a minute and more
BUSY = "safe_busy"  # lidar and model at 40 Hz


@check(points=5, asks=WIRING, task=1, scenarios=("safe_pass",), needs=())
def test_wiring(runs: Runs) -> None:
    """The node starts, spins, listens to 3 topics and publishes on /cmd_vel and /diagnostics."""
    wired(runs)


@check(points=5, asks=TIMING, task=1, scenarios=(*EVERY, LONG), hint="1.1")
def test_control_rate(runs: Runs) -> None:
    """One command at each tick, 20 a second from the start on, whatever the reason for it."""
    for recording in runs:
        one_a_tick(recording)


@check(points=5, asks=DECISION, task=4, scenarios=("safe_pass", "safe_obstacle"), hint="1.1")
def test_passes_on(runs: Runs) -> None:
    """What is safe is passed on as it is, backwards too; the four other fields are zero."""
    help = "Where no rule stops or limits it, linear.x and angular.z go out as they came in."
    follows(runs.only("safe_pass"), "settled", help=help)
    for recording in runs:
        help = "Fill in a new Twist; only linear.x and angular.z are passed on."
        zero(recording, FIELDS[1:5], help)


@check(points=5, asks=SAFETY, task=4, scenarios=("safe_limits", LONG), hint="4.1")
def test_limits(runs: Runs) -> None:
    """linear.x is clamped to ±0.5 m/s and angular.z to ±1.9 rad/s, for however long."""
    for recording in runs:
        help = "Clamp both ways, max(-limit, min(limit, value)), whatever the model asks."
        within(recording, CONTRACT.limits, help)
    help = "Clamp to the limit, not to zero; what is within is not touched."
    follows(runs.only("safe_limits"), "settled", help=help)


@check(points=10, asks=DECISION, task=4, scenarios=EVERY, hint="4.2")
def test_acceleration(runs: Runs) -> None:
    """linear.x rises by at most 0.045 m/s a tick, from the last command published or from 0."""
    help = (
        "The most is max(0, last) + 0.045, where last is what you published one tick ago, "
        "whatever the reason for it was."
    )
    follows(runs, "rise", help=help, tolerance=ZERO)
    follows(runs.only("safe_ramp"), "rising", help=help)


@check(points=5, asks=SAFETY, task=4, scenarios=("safe_ramp", BUSY), hint="4.2")
def test_never_delays(runs: Runs) -> None:
    """Slowing down, stopping and driving backwards take effect at once."""
    help = "The limit is for getting faster forwards only: min(asked, max(0, last) + 0.045)."
    follows(runs, "slower", help=help)


@check(points=10, asks=SAFETY, task=3, scenarios=("safe_e_stop", BUSY, BUTTON, LONG), hint="3.1")
def test_e_stop(runs: Runs) -> None:
    """While the last /e_stop was true the robot stands, from the next tick on."""
    help = "Keep the last /e_stop, whatever else holds: true holds until a false comes."
    heeds(runs, "e_stop", help=help)
    heeds(runs.only("safe_e_stop", BUSY), "moves", help=help)


@check(points=5, asks=SAFETY, task=3, scenarios=("safe_bad_command", LONG), hint="3.2")
def test_bad_command(runs: Runs) -> None:
    """A command with NaN or infinity in a field stops the robot until a good one comes."""
    help = "math.isfinite on each field, before you compare: comparisons with NaN are false."
    heeds(runs, "bad_command", help=help)
    heeds(runs.only("safe_bad_command"), "moves", help=help)


@check(points=5, asks=SAFETY, task=3, scenarios=("safe_stale_command", BUTTON, LONG), hint="1.2")
def test_stale_command(runs: Runs) -> None:
    """Without a raw command for more than 0.5 s (or at all) the robot stands."""
    help = "Note when each command arrives, and look at its age at every tick."
    heeds(runs, "stale_command", help=help)
    heeds(runs.only("safe_stale_command"), "moves", help=help)


@check(points=5, asks=SAFETY, task=3, scenarios=("safe_stale_scan", BUTTON, LONG), hint="1.2")
def test_stale_scan(runs: Runs) -> None:
    """Without a scan for more than 0.5 s (or at all) the robot stands."""
    help = "Note when each scan arrives, and look at its age at every tick."
    heeds(runs, "stale_scan", help=help)
    heeds(runs.only("safe_stale_scan"), "moves", help=help)


@check(points=5, asks=SAFETY, task=3, scenarios=("safe_blind",), hint="3.2")
def test_blind_scan(runs: Runs) -> None:
    """When the newest scan has no usable reading ahead the robot stands; +inf is free."""
    help = "The newest scan counts: if it is blind, an older distance is no help."
    heeds(runs, "stale_scan", help=help)
    heeds(runs, "moves", help=help)


@check(points=5, asks=SAFETY, task=4, scenarios=("safe_obstacle", LONG, BUSY), hint="3.1")
def test_obstacle(runs: Runs) -> None:
    """Below 0.5 m ahead no driving forwards; turning (clamped) and backing out as asked."""
    help = (
        "Only if linear.x > 0 and something is nearer than 0.5 m ahead: linear.x = 0, "
        "angular.z as asked, within ±1.9."
    )
    follows(runs, "obstacle", help=help, explain=own_reason)
    follows(runs.only("safe_obstacle"), "settled", help=help)
    heeds(runs.only("safe_obstacle"), "moves", help=help)


@check(points=5, asks=SAFETY, scenarios=("safe_drive",))
def test_no_contact(runs: Runs) -> None:
    """With a model that never brakes the robot touches nothing, and drives."""
    keeps_distance(runs, clearance=0.0)


@check(points=5, asks=DECISION, task=5, scenarios=SHORT, hint="5.2")
def test_status_text(runs: Runs) -> None:
    """Each message on /diagnostics has one status, whose text begins with a reason word."""
    help = "status.message begins with the word itself; anything may follow after a space."
    follows(runs, "report", topic=DIAGNOSTICS_TOPIC, help=help)


@check(
    points=5, asks=DECISION, task=5, scenarios=SHORT, needs=("wiring", "status_text"), hint="3.1"
)
def test_reasons(runs: Runs) -> None:
    """The reason is the right one, and a new one is reported at once."""
    help = (
        "Report when the reason differs from that of the last report. The rule that gives the "
        "command also gives the reason."
    )
    follows(runs, "alone", topic=DIAGNOSTICS_TOPIC, help=help)


@check(
    points=5,
    asks=DECISION,
    task=5,
    scenarios=("safe_first_match", "safe_first_button", LONG),
    needs=("wiring", "status_text"),
    hint="3.1",
)
def test_first_match(runs: Runs) -> None:
    """When two rules match, the one that comes first gives the reason, for as long as they do."""
    help = "In this order: e_stop, bad_command, stale_command, stale_scan, obstacle, limited, ok."
    follows(runs, "first", topic=DIAGNOSTICS_TOPIC, help=help)


@check(
    points=5,
    asks=DECISION,
    task=5,
    scenarios=(*SHORT, "safe_blind"),
    needs=("wiring", "status_text"),
    hint="5.3",
)
def test_levels(runs: Runs) -> None:
    """Level OK for ok, WARN for limited and obstacle, ERROR for the rest."""
    help = "The level is a byte of the reason's own: DiagnosticStatus.OK, .WARN or .ERROR."
    every_level = sorted(set(LEVELS.values()))  # each has to occur: it judges its own reason
    follows(runs, *every_level, topic=DIAGNOSTICS_TOPIC, help=help)


@check(points=5, asks=TIMING, task=5, scenarios=(*EVERY, LONG), hint="5.1")
def test_heartbeat(runs: Runs) -> None:
    """/diagnostics is never silent for longer than a second, however long a reason holds."""
    for recording in runs:
        reports_often(recording)
