"""The field checks of exercise 7: no points, but the badge *field-ready*."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.field import BY_ANGLE, FieldSuite
from grader.checks.verbs import follows, keeps_distance
from grader.exercises.safety_supervisor.words import one_a_tick, own_reason, reports_often


def _keeps_the_contract(runs: Runs, help: str) -> None:
    """Fail unless the whole contract holds in these scenarios."""
    for recording in runs:
        one_a_tick(recording)
        reports_often(recording)
    follows(runs, help=help, explain=own_reason)
    keeps_distance(runs, clearance=0.0, help=help)


field = FieldSuite(_keeps_the_contract)

test_field_lds01 = field.lds01("safe_field_lds01")
test_field_wide_lidar = field.wide_lidar("safe_field_wide")
test_field_best_effort = field.best_effort(
    "safe_field_best_effort", help="Subscribe to /scan with qos_profile_sensor_data."
)
test_field_mirrored_world = field.mirrored_world("safe_field_mirrored", help=BY_ANGLE)
test_field_speckle = field.speckle(
    "safe_field_speckle", help="Ignore a NaN; the other readings of the scan still count."
)
test_field_lost_scans = field.lost_scans(
    "safe_field_lost_scans",
    title="Counts ages from the arrival: scans come late, and one in five never does.",
    help="The age of a scan counts from its arrival, not from its stamp.",
)
test_field_turned_lidar = field.check(
    "safe_field_turned",
    title="Looks ahead of the robot where the lidar is mounted turned, as /tf_static says.",
    help="Angle 0 is where the lidar looks. Where is the robot's front in the scan's frame? "
    'lookup_transform(scan.header.frame_id, "base_link", Time()) of tf2_ros says it.',
    hint="1.4",
)
