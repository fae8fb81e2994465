"""What two gradings of the same solutions have to share."""

from dataclasses import replace

from grader.authoring.digests import comparable, differences
from grader.recording import COMPLETED, Outcome, Recording
from sim.messages import twist
from sim.scenario_files import load_scenario
from sim.simulation import Simulation


def test_what_differs_is_named_for_claims_that_both_have() -> None:
    before = {"a": {"x": "1", "y": "2", "verdict": "100"}, "b": {"x": "1"}}
    after = {"a": {"x": "1", "y": "3"}, "c": {"x": "1"}}
    assert differences(before, after) == ["a: verdict", "a: y"]
    assert differences(before, before) == []


def test_the_order_of_two_topics_at_one_moment_means_nothing() -> None:
    simulation = Simulation(load_scenario("demo_wall"))
    two = tuple(twist(time=1, linear_x=0.5, topic=topic) for topic in ("/cmd_vel", "/other"))
    one = Recording(
        scenario=simulation.scenario, layout=simulation.layout, seed=1, duration_s=1.0,
        delivered=(), published=two, truth=simulation.truth(), outcome=Outcome(COMPLETED),
        endpoints=(),
    )  # fmt: skip
    other = replace(one, published=two[::-1])
    assert comparable(one).digest() == comparable(other).digest()
    other = replace(one, published=two[:1])
    assert comparable(one).digest() != comparable(other).digest()
