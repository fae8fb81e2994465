"""Right solutions get full marks in the worlds of a few students; `make students` asks 200."""

import os

import msgspec
import pytest

from grader.authoring.fairness import Shared, examine, fingerprint, is_own, right_solutions
from grader.authoring.proof import Claim
from grader.course.exercises import all_exercises
from grader.recording import COMPLETED, Outcome, Recording
from sim.messages import twist
from sim.scenario_files import load_scenario
from sim.simulation import Simulation

EXERCISES = [exercise.slug for exercise in all_exercises()]
QUICK = ("trend_memory",)  # in `make test`
OTHER = 12_345  # a seed
STUDENTS = int(os.environ.get("COURSE_STUDENTS", "0"))  # make students: 200 for each reference
RIGHT = [claim for slug in EXERCISES for claim in right_solutions(slug)] if STUDENTS else []


@pytest.mark.parametrize(
    "slug",
    [pytest.param(slug, marks=() if slug in QUICK else pytest.mark.long) for slug in EXERCISES],
)
def test_a_student_gets_full_marks_in_worlds_of_their_own(slug: str) -> None:
    (reference,) = right_solutions(slug, variants=False)
    student = EXERCISES.index(slug)  # another one in each exercise
    (verdict,) = examine(reference, [student])
    assert not verdict.against
    assert 0 < verdict.own <= verdict.runs


@pytest.mark.long
@pytest.mark.parametrize("claim", RIGHT, ids=[claim.name for claim in RIGHT])
def test_right_solutions_get_full_marks_in_everybodys_worlds(claim: Claim) -> None:
    """Variants, and the field checks, meet a tenth of the students."""
    few = max(1, STUDENTS // 10)
    students = range(STUDENTS if claim.kind == "reference" else few)
    verdicts = examine(claim, students, field=few)
    assert {one.student: one.against for one in verdicts if one.against} == {}


# --- what is the same for every student ----------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "own"),
    [
        ("avoid_zones", True),  # scripted scans are jittered
        ("goal_origin_to_5_3", False),  # a fixed start in an empty world
        ("avoid_store", True),  # clutter
        ("goal_behind", True),  # another start
        ("trend_stamps", True),  # the network delays scans at random
        ("slow_field_lost_scans", True),  # scans are lost at random
    ],
)
def test_which_scenarios_are_a_students_own(name: str, own: bool) -> None:
    assert is_own(load_scenario(name), OTHER) is own


def test_noise_that_only_shows_on_the_way_is_found() -> None:
    scenario = load_scenario("goal_origin_to_5_3")
    noisy = msgspec.structs.replace(
        scenario, odometry=msgspec.structs.replace(scenario.odometry, position_noise=0.01)
    )
    prints = set()
    for seed in (1, 2):
        prints.add(fingerprint(Simulation(noisy, seed)))
    assert len(prints) == 2


def recording(seed: int, speed: float) -> Recording:
    simulation = Simulation(load_scenario("avoid_zones"))
    return Recording(
        scenario=simulation.scenario,
        layout=simulation.layout,
        seed=seed,
        duration_s=1.0,
        delivered=(),
        published=(twist(time=10**8, linear_x=speed),),
        truth=simulation.truth(),
        outcome=Outcome(COMPLETED),
        endpoints=(),
    )


def test_a_run_is_used_again_when_two_students_had_the_same() -> None:
    shared = Shared()
    shared.add(recording(seed=1, speed=0.5))
    assert shared.get("avoid_zones") is None
    shared.add(recording(seed=2, speed=0.4))  # the node draws random numbers
    assert shared.get("avoid_zones") is None
    shared.add(recording(seed=3, speed=0.4))
    assert shared.get("avoid_zones") is not None
    shared.forget()
    assert shared.get("avoid_zones") is None
