"""The graph of a run: what is wrong is said as in the terminal, and names stay text."""

import re
from dataclasses import replace

import pytest
from msgspec.structs import replace as changed
from test_replay import drive

from grader.drive import event_lines
from grader.drive.topics import topic_lines
from grader.recording import Endpoint, Recording
from grader.recording.hands import deeds
from grader.report.graph import graph_html
from grader.report.page import page_payload
from sim.scenario_files import load_scenario

SCAN, TWIST = "sensor_msgs/msg/LaserScan", "geometry_msgs/msg/Twist"
HEARS = Endpoint("subscription", "/b", "/x", "std_msgs/msg/String", "reliable", "volatile")
SAYS = Endpoint("publisher", "/a", "/x", "std_msgs/msg/String", "reliable", "volatile")
EVIL = "/<img src=x onerror=1>&\"'</svg></template><script>\u202e\x1b[31m\ud800@@CSP@@"


def run(*ends: Endpoint) -> Recording:
    return replace(drive(2.0), endpoints=ends)


@pytest.mark.parametrize(
    ("ends", "said"),
    [
        ((SAYS, HEARS), []),
        ((SAYS,), []),  # a topic with one end is an ordinary topic
        ((changed(HEARS, topic="/scann", type=SCAN),),
         ["nobody publishes this topic; the robot publishes /scan"]),
        ((changed(HEARS, type="std_msgs/msg/Bool"), SAYS),
         ["nothing arrives: /a publishes std_msgs/msg/String here"]),
        ((changed(SAYS, reliability="best_effort"), HEARS),
         ["nothing arrives: best effort publisher and reliable subscription"]),
        ((changed(SAYS, topic="/mod"), changed(HEARS, topic="/mode")),
         ["nobody listens here: /b listens to /mode",
          "nobody publishes this topic; /a publishes /mod"]),
        ((changed(SAYS, topic="/cmd_ve", type=TWIST),),
         [f"nobody listens here: the robot takes {TWIST} on /cmd_vel"]),
        ((Endpoint("client", "/a", "/go", "std_srvs/srv/Trigger"),),
         ["nobody offers this service: calls are never answered"]),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_as_in_the_terminal(
    ends: tuple[Endpoint, ...], said: list[str]
) -> None:
    graph, lines = graph_html(run(*ends)), topic_lines(run(*ends))
    assert re.findall(r"<li><b>[^<]*</b>, /[ab]: ([^<]*)</li>", graph) == said
    assert [line[13:] for line in lines if line.startswith("    WARNING: ")] == said
    assert graph.count('class="graph-edge is-bad"') == len(said)
    assert (f"✗ {len(said)} fault" in graph) is bool(said)
    assert len(re.findall(r">✗ \d<", graph)) == len(said)  # in the table
    alone = sum(text.startswith("nobody") for text in said) + ("/cmd_vel" in "".join(said))
    for sign in (">✗ nobody<", 'class="graph-edge is-missing"', 'class="graph-nobody"'):
        assert graph.count(sign) == alone


@pytest.mark.parametrize(("outcome", "faults"), [("", 1), ("fail", 1), ("pass", 0)])
def test_what_a_run_leaves_out_is_no_fault_where_its_checks_passed(
    outcome: str, faults: int
) -> None:
    recording = run(changed(HEARS, topic="/laser"))
    check = {"outcome": outcome, "scenario": recording.name, "time": None}
    (graph,) = page_payload({"checks": [check] if outcome else []}, [recording], "x")["graphs"]
    assert graph.count("<li>") == faults


def test_what_the_scenario_names_is_no_fault_and_a_stand_in_is_told_of() -> None:
    driver = changed(SAYS, node="/shuttle/driver", topic="/shuttle/cmd_vel_raw", type=TWIST)
    alone, elsewhere = run(driver), run(changed(driver, topic="/cmd_vel_raw"))
    scenario = load_scenario("shuttle_driver")
    named, other = (replace(each, scenario=scenario) for each in (alone, elsewhere))
    tf = run(changed(HEARS, topic="/tf", type="tf2_msgs/msg/TFMessage"))
    static = replace(tf, delivered=(*tf.delivered, replace(tf.delivered[0], topic="/tf_static")))
    seen = [graph_html(each).count("<li>") for each in (alone, named, other, tf, static)]
    assert seen == [1, 0, 1, 1, 0]
    stood_in = replace(alone, scenario=load_scenario("shuttle_launch"))
    assert "the course's own shuttle_part.py ran in place of" in "".join(event_lines(stood_in))


def test_an_e_stop_that_is_said_twice_is_one_deed() -> None:
    released = replace(drive(4.0), scenario=load_scenario("safe_pass"))
    assert [each.text for each in deeds(released)] == ["e-stop released"]


def test_names_stay_text() -> None:
    ends = (HEARS, changed(SAYS, topic="/y"), Endpoint("client", "/a", "/z", "a/srv/B"))
    calm = graph_html(run(*ends))
    evil = (
        Endpoint(e.kind, *[EVIL + text for text in (e.node, e.topic, e.type, "q", "d")], 0, EVIL)
        for e in ends
    )
    hostile = graph_html(run(*evil))
    hostile.encode("utf-8")
    assert not re.search("[\u202e\x1b]", hostile)
    assert {*re.findall(r"</?(\w+)", hostile)} == {*re.findall(r"</?(\w+)", calm)} | {"wbr"}
    assert {*re.findall(r'(\w+)="', hostile)} == {*re.findall(r'(\w+)="', calm)}


def test_of_very_many_ends_those_with_faults_are_drawn() -> None:
    many = [changed(SAYS, topic=f"/t{i}") for i in range(100)]
    graph = graph_html(run(*many, changed(HEARS, topic="/zzz", type=SCAN)))
    assert "41 ends left out" in graph
    assert 'class="graph-edge is-bad"' in graph
    assert len(graph) < 60_000
    assert graph_html(run()) == ""
