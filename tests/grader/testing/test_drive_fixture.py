"""The fixture `drive`: arguments, errors, and what a failure says (grader/testing, drives, run)."""

import shutil
from pathlib import Path

import pytest

from grader.course.exercises import SOLUTIONS
from rclpy_virtual_time.tests.testing.outside import Session, pytest_in, write

AGENT = SOLUTIONS / "obstacle_avoidance" / "obstacle_avoidance_agent.py"

NODES = {
    "dies": """
        import rclpy
        from rclpy.node import Node
        from sensor_msgs.msg import LaserScan

        class Agent(Node):
            def __init__(self):
                super().__init__("agent")
                self.create_subscription(LaserScan, "/scan", self.on_scan, 10)
                self.seen = 0

            def on_scan(self, scan):
                self.get_logger().info(f"scan {self.seen}")
                self.seen += 1
                if self.seen == 5:
                    raise ValueError("no idea")

        rclpy.init()
        rclpy.spin(Agent())
        """,
    "driving_style": "SPEED = 0.1",  # it lies beside the node that imports it
    "stamped": """
        import rclpy
        from driving_style import SPEED
        from geometry_msgs.msg import TwistStamped
        from rclpy.node import Node

        class Agent(Node):
            def __init__(self):
                super().__init__("agent")
                self.publisher = self.create_publisher(TwistStamped, "/cmd_vel", 10)
                self.speed = self.declare_parameter("speed", SPEED).value
                self.create_timer(0.1, self.tick)

            def tick(self):
                message = TwistStamped()
                message.twist.linear.x = self.speed
                self.publisher.publish(message)

        rclpy.init()
        rclpy.spin(Agent())
        """,
}
TESTS = """
    from pathlib import Path

    import pytest


    @pytest.fixture(scope="module")
    def wall(drive):
        return drive("my_agent.py", scenario="avoid_wall", duration=5.0)


    def test_shapes(wall, tmp_path):
        assert wall.t.shape == wall.clearance.shape == wall.contact.shape == wall.truth.yaw.shape
        assert (wall.t[0], wall.t[-1], wall.duration) == (0.0, 5.0, 5.0)
        assert len(wall.scans()) == 50 and wall.scans()[0].ranges.shape == (360,)
        assert wall.odometry().t.shape == wall.odometry().x.shape
        twists = wall.twists("/cmd_vel")
        assert twists.t.shape == twists.linear_x.shape == (50,)
        assert wall.log[0] == "Obstacle avoidance agent started"
        assert wall.outcome.completed and wall.outcome.kind == "completed"
        t, message = wall.messages("/cmd_vel")[0]
        assert (t, message.linear.x) == (wall.twists().t[0], 0.5)
        assert wall.messages("/nobody") == []
        assert wall.report(tmp_path / "run.html").stat().st_size > 100_000


    def test_failure_of_a_shared_run(wall):
        assert wall.clearance.min() > 9.0


    def test_parameters_and_stamps(drive):
        kept = drive("stamped.py", scenario="demo_open", duration=2.0, parameters={"speed": 0.3})
        assert kept.truth.x[-1] == pytest.approx(kept.truth.x[0])
        asked = {"scenario": "demo_open", "duration": 2.0, "parameters": {"speed": 0.3}}
        run = drive("stamped.py", **asked, stamped=True)
        assert run.truth.v[-1] == pytest.approx(0.3)


    def test_seed_lidar_goals(drive):
        one, other = (
            drive("my_agent.py", scenario="avoid_wall", duration=1.0, seed=seed) for seed in (1, 2)
        )
        assert one.digest() != other.digest()
        asked = {"duration": 2.0, "lidar": "lds01", "goals": [(1, 2), (3, 4)]}
        run = drive(Path("my_agent.py"), scenario="mine.toml", **asked)
        assert run.recording.name == "mine"
        goals = [(t, m.pose.position.x) for t, m in run.messages("/goal_pose")]
        assert goals == [(0.5, 1.0), (1.5, 3.0)]
        assert run.scans()[0].angle_min == 0.0


    def test_a_dead_node(drive):
        run = drive("dies.py", scenario="avoid_wall")
        assert run.outcome.kind == "exception" and run.t[-1] < 2.0 and len(run.scans()) == 5
        assert run.clearance.min() > 5.0  # which fails


    def test_two_drives(drive):
        first = drive("my_agent.py", scenario="avoid_wall", duration=1.0)
        second = drive("dies.py", scenario="avoid_cart")
        assert first.digest() == second.digest()


    def test_no_file(drive):
        drive("missing.py", scenario="avoid_wall")


    def test_no_scenario(drive):
        drive("my_agent.py", scenario="avoid_well")


    def test_no_duration(drive):
        drive("my_agent.py", scenario="avoid_wall", duration=0)


    def test_no_lidar(drive):
        drive("my_agent.py", scenario="avoid_wall", lidar="ldds")


    @pytest.mark.parametrize("name", ["a/b c", "ü"])
    def test_strange_name(wall, name):
        assert False
    """
PASS = {
    "shapes", "parameters_and_stamps", "seed_lidar_goals",
}  # fmt: skip
ERRORS = {
    "no_file": "drive: {folder}/missing.py: no such file",
    "no_scenario": "drive: no scenario is called 'avoid_well'; did you mean 'avoid_wall'?",
    "no_duration": "drive: duration 0: expected a time in seconds, such as 20",
    "no_lidar": "drive: unknown lidar profile 'ldds'",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("student").resolve()
    shutil.copy(AGENT, folder / "my_agent.py")
    write(folder, **NODES, test_it=TESTS)
    (folder / "mine.toml").write_text('extends = "avoid_wall"\ntitle = "Mine"\nduration = 1.0\n')
    return folder


@pytest.fixture(scope="module")
def session(folder: Path) -> Session:
    return pytest_in(folder, "--replays", "kept")


def test_right_tests_pass(session: Session) -> None:
    passed = {name for name, outcome in session.outcomes().items() if outcome == "passed"}
    assert passed == {f"test_it.test_{name}" for name in PASS}, session.output


@pytest.mark.parametrize("name", ERRORS)
def test_mistakes_are_told_in_one_line_beside_the_students_own(
    session: Session, folder: Path, name: str
) -> None:
    result = session.tests[f"test_it.test_{name}"]
    assert result.outcome == "failed"
    assert result.text.startswith("Failed: " + ERRORS[name].format(folder=folder))
    assert ">       drive(" in result.text
    assert "grader/" not in result.text
    assert "sim/" not in result.text


def test_a_failure_says_what_the_robot_did_and_where_the_replay_is(
    session: Session, folder: Path
) -> None:
    said = _section(session, "test_failure_of_a_shared_run")
    replay = folder / "kept" / "test_it-test_failure_of_a_shared_run.html"
    assert "my_agent.py in avoid_wall, seed 11\n  5.0 s simulated" in said
    assert f"Replay: {replay}" in said
    assert "A wall ahead" in replay.read_text("utf-8")
    assert (folder / "kept" / ".gitignore").read_text() == "*\n"


def test_a_dead_node_is_named_with_its_traceback_and_log(session: Session) -> None:
    said = _section(session, "test_a_dead_node")
    assert "the node ended at 0.4 s: exception: ValueError: no idea (line 16, in on_scan)" in said
    assert 'raise ValueError("no idea")' in said
    assert "0.413 s  scan 4" in said


def test_the_replay_has_all_drives_of_the_test(session: Session, folder: Path) -> None:
    said = _section(session, "test_two_drives")
    assert said.index("my_agent.py in avoid_wall") < said.index("dies.py in avoid_cart")
    page = (folder / "kept" / "test_it-test_two_drives.html").read_text("utf-8")
    assert "A wall ahead" in page
    assert "the node ended at" not in said.partition("dies.py")[0]


def test_names_of_replays_are_names_of_files(session: Session, folder: Path) -> None:
    assert _section(session, "test_strange_name[a/b c]").count("Replay: ") == 1
    names = {path.name for path in (folder / "kept").iterdir()}
    strange = {name for name in names if "strange" in name}
    assert len(strange) == 2, names


def test_tests_without_the_fixture_start_nothing(tmp_path: Path) -> None:
    write(tmp_path, test_plain="import sys\ndef test_it(): assert 'pymunk' not in sys.modules\n")
    assert pytest_in(tmp_path).outcomes() == {"test_plain.test_it": "passed"}


def _section(session: Session, test: str) -> str:
    """Return what a test's failure says of the robot."""
    start = session.output.index(f"_ {test} _")
    begin = session.output.index("- what the robot did -", start)
    return session.output[begin : session.output.index("\n____", begin)]
