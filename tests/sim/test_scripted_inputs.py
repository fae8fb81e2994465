"""What a scenario can send besides sensors: raw commands, an emergency stop, parameters, models."""

import numpy as np
from simulated import refusal

from sim.messages import BOOL, decode, twist_from_cdr
from sim.scenario_files import scenario_from_json, scenario_from_toml, scenario_to_json
from sim.simulation import Simulation

HEAD = 'title = "t"\nduration = 2.0\n'
TAIL = "\n[world]\n[lidar]\nenabled = false\n[odometry]\nenabled = false\n"


def messages(body: str) -> list:
    simulation = Simulation(scenario_from_toml(HEAD + body + TAIL, "here"))
    return simulation.advance(2_000_000_000)


def test_a_raw_stream_has_its_rate_and_its_ends() -> None:
    stream = (
        "raw = [{ from = 0.5, to = 1.0, linear_x = 0.3, others = [2, inf, 4, 5], angular_z = nan }]"
    )
    sent = messages(stream)

    np.testing.assert_allclose([m.time / 1e9 for m in sent], 0.5 + np.arange(10) * 0.05)
    assert {m.topic for m in sent} == {"/cmd_vel_raw"}
    assert str(twist_from_cdr(sent[0].data)) == "(0.3, 2.0, inf, 4.0, 5.0, nan)"


def test_every_second_command_of_a_model_that_wavers_is_smaller() -> None:
    stream = "raw = [{ from = 0.5, to = 0.7, linear_x = 0.5, angular_z = -1 }]"
    sent = [twist_from_cdr(m.data) for m in messages(stream + "\n[faults]\nraw_waver = 0.1")]

    assert [(row[0], row[5]) for row in sent] == [(0.5, -1.0), (0.45, -0.9)] * 2


def test_streams_follow_one_another_without_overlap() -> None:
    streams = "raw = [{ from = 0.5, to = 1.0, rate = 10 }, { from = 1.0, to = 1.2, rate = 10 }]"

    assert [m.time for m in messages(streams)] == [i * 10**8 for i in range(5, 12)]


def test_an_emergency_stop_is_sent() -> None:
    (sent,) = messages("script = [{ at = 1.0, e_stop = true }]")

    assert (sent.topic, sent.time) == ("/e_stop", 10**9)
    assert decode(sent.data, BOOL).data is True


def test_parameters_and_models_survive_json() -> None:
    node = (
        '[node]\nparameters = { model_path = "m.pkl", max_speed = 0.4, on = true, n = 3 }\n'
        'models = { "m.pkl" = { probe = "echo", settings = { feature = 2.0 } } }\n'
    )
    scenario = scenario_from_toml(HEAD + TAIL + node, "here")

    assert scenario_from_json(scenario_to_json(scenario)) == scenario
    assert scenario.node.parameters == {"model_path": "m.pkl", "max_speed": 0.4, "on": True, "n": 3}
    assert scenario.node.models["m.pkl"].probe == "echo"


def test_a_stream_that_ends_before_it_begins_is_refused() -> None:
    said = refusal(scenario_from_toml, HEAD + "raw = [{ from = 1.0, to = 0.5 }]" + TAIL, "here")
    assert "raw[0]: expected from < to" in said
