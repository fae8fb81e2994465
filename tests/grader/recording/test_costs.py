"""What computing cost, from the judge's measure."""

from dataclasses import replace

import numpy as np
import pytest

from grader.recording import Compute, Live, Outcome, Recording, account_of, costs_of
from sim.scenario_files import load_scenario
from sim.simulation import Simulation

NAN = float("nan")


def recording(wall: list[float], cpu: list[float], duration: float = 1.0) -> Recording:
    """A scan every 100 ms; the first exchange is the start-up, then one a scan."""
    simulation = Simulation(load_scenario("demo_wall"))
    sent = [m for m in simulation.advance(10**9) if m.topic == "/scan"][: len(wall) - 1]
    times = np.array([0.0, *(message.time / 1e9 for message in sent)])
    return Recording(
        scenario=simulation.scenario,
        layout=simulation.layout,
        seed=simulation.seed,
        duration_s=duration,
        delivered=tuple(sent),
        published=(),
        truth=simulation.truth(),
        outcome=Outcome("completed"),
        endpoints=(),
        compute=Compute(times, np.array(wall), np.array(cpu), np.zeros(len(wall))),
    )


def test_the_start_up_is_left_out() -> None:
    costs = costs_of(recording([9.0, 0.002, 0.004, 0.003], [9.0, 0.002, 0.004, 0.003]))
    assert costs is not None
    assert (costs.p50, costs.worst) == pytest.approx((0.003, 0.004))
    assert costs.p99 == pytest.approx(np.percentile([0.002, 0.004, 0.003], 99))
    assert (costs.late, costs.period, costs.load) == pytest.approx((0, 0.1, 0.009))
    assert costs.keeps_up


def test_waits_and_other_programs_do_not_count() -> None:
    costs = costs_of(recording([0.0, 0.5, 0.2, 0.01], [0.0, 0.004, 0.004, 0.04]))
    assert costs is not None
    assert costs.worst == pytest.approx(0.01)
    unknown = costs_of(recording([0.0, 0.004, 0.002], [NAN, NAN, NAN]))  # then wall time counts
    assert unknown is not None
    assert unknown.worst == pytest.approx(0.004)


def test_in_real_time_the_first_exchange_counts() -> None:
    live = Live(epoch=0, reason="", lateness=0.0, starved=0.0)
    run = recording([0.2, 0.001], [0.2, 0.001])
    times = np.array([message.time / 1e9 for message in run.delivered])
    compute = Compute(np.repeat(times, 2), run.compute.wall, run.compute.cpu, np.zeros(2))
    costs = costs_of(replace(run, live=live, compute=compute))
    assert costs is not None
    assert costs.worst == pytest.approx(0.2)


def test_where_no_cpu_time_is_told_nobody_is_blamed() -> None:
    [said] = account_of(recording([0.0] + [0.3] * 10, [NAN] * 11))
    assert said.endswith("period is 100 ms. By the clock: what else the machine had to do is in it")


def test_a_node_that_got_no_message_has_no_costs() -> None:
    assert costs_of(recording([1.0], [1.0])) is None
    assert account_of(recording([1.0], [1.0])) == []


def test_a_run_in_which_computing_took_time_says_so_instead_of_warning() -> None:
    scans = [0.3] * 10
    run = replace(recording([0.0, *scans], [0.0, *scans]), charged=True)
    _, said = account_of(run)
    assert "--charge-compute" in said


@pytest.mark.parametrize(
    ("scans", "said"),
    [
        ([0.001, 0.002], []),
        ([0.001, 0.101], ["WARNING: once the node computed for longer than the lidar's period"]),
        ([0.15, 0.001, 0.2], ["WARNING: 2 times the node computed for longer"]),
        ([0.3] * 10, ["it computes 3.0 s for each second", "about 3.3 of 10 scans a second"]),
    ],
)
def test_what_is_said(scans: list[float], said: list[str]) -> None:
    first, *rest = account_of(recording([0.0, *scans], [0.0, *scans]))
    assert first.startswith("Compute: ")
    assert first.endswith("the lidar's period is 100 ms")
    assert len(rest) == bool(said)
    assert all(part in rest[0] for part in said)
