"""The field checks of exercise 7: no points, but the badge *field-ready*."""

from __future__ import annotations

from grader.checks.driving import require_no_contact
from grader.checks.old_field import BY_ANGLE, FieldSuite
from grader.exercises.safety_supervisor.contract import ticks
from grader.exercises.safety_supervisor.evidence import (
    require_levels,
    require_reasons,
    require_right,
    require_text,
)
from grader.exercises.safety_supervisor.timing import require_heartbeat, require_rate
from grader.recording import Recording


def _require_contract(recording: Recording, help: str) -> None:
    """Fail unless the whole contract holds in this scenario."""
    require_rate(recording)
    require_right(recording, ticks(recording, silences=True), lambda tick: tick.is_right, help)
    require_text(recording)
    require_reasons(recording, help)
    require_levels(recording)
    require_heartbeat(recording)
    require_no_contact(recording, help)


field = FieldSuite("safety_supervisor", _require_contract)

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
