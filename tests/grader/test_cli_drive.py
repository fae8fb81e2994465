"""course drive, in a process of its own."""

from pathlib import Path

import pytest
from command_line import ROOT, SHORT, course

from grader.recording import bag

BURGER = (ROOT / "tests" / "nodes" / "turtlebot3_burger.py").read_text("utf-8")
STAMPED = (  # as TurtleBot 3 takes it from Jazzy on
    BURGER.replace("Twist", "TwistStamped")
    .replace("twist.linear", "twist.twist.linear")
    .replace("TwistStamped()", "TwistStamped(header=msg.header)")
)

# --- drive ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "type"),
    [
        pytest.param(BURGER, "geometry_msgs/msg/Twist ", marks=pytest.mark.long, id="plain"),
        pytest.param(STAMPED, "geometry_msgs/msg/TwistStamped ", id="stamped"),
    ],
)
def test_other_peoples_nodes_drive(text: str, type: str, tmp_path: Path) -> None:
    node = tmp_path / "burger" / "turtlebot3_burger.py"
    node.parent.mkdir()
    node.write_text(text, "utf-8")
    done = course(
        "drive", node, "--scenario", "demo_wall", "--lidar", "lds01",
        "--bag", tmp_path / "bag", "--report", tmp_path / "drive.html",
    )  # fmt: skip
    drive = bag.load(tmp_path / "bag")

    assert (done.code, done.err) == (0, "")
    assert f"-> /cmd_vel  {type}" in done.out
    assert "<- /scan  sensor_msgs/msg/LaserScan  best_effort" in done.out
    assert "TOUCHED" not in done.out
    assert "WARNING" not in done.out
    assert not drive.truth.contact.any()
    assert drive.truth.x[-1] - drive.truth.x[0] > 2.0
    assert drive.truth.v[-1] == pytest.approx(0.0, abs=1e-6)
    assert 0.2 < drive.truth.clearance[-1] < 0.5
    assert {len(scan.ranges) for scan in drive.scans()} == {360}
    assert (tmp_path / "drive.html").stat().st_size > 10_000


def test_goals_parameters_and_seed_of_a_drive(tmp_path: Path) -> None:
    node = tmp_path / "node.py"
    node.write_text(
        "import rclpy\nfrom rclpy.node import Node\nfrom geometry_msgs.msg import PoseStamped\n"
        "rclpy.init()\nnode = Node('listener')\n"
        "print(*(node.declare_parameter(*p).value for p in (('gain', 1.0), ('name', ''))))\n"
        "node.create_subscription(PoseStamped, 'goal_pose', lambda _: None, 10)\nrclpy.spin(node)\n"
    )
    done = course(
        "drive", node, "--scenario", "demo_open", "--duration", "2", "--goal", "5", "-3",
        "--goal", "0.5", "0", "--param", "gain:=0.25", "--param", "name:=two words",
        "--seed", "7", "--bag", tmp_path / "bag",
    )  # fmt: skip
    drive = bag.load(tmp_path / "bag")

    assert (done.code, done.err) == (0, "")
    goals = drive.goals()
    assert [goals.t.tolist(), goals.x.tolist(), goals.y.tolist()] == [[0.5, 1.5], [5, 0.5], [-3, 0]]
    assert [line.text for line in drive.log] == ["0.25 two words"]
    assert drive.duration_s == 2.0
    assert "node.py in demo_open, seed 7\n" in done.out


def test_what_cannot_be_started_is_wrong_usage(tmp_path: Path) -> None:
    (tmp_path / "package.xml").write_text("<package><name>mine</name></package>")
    entries = "{'console_scripts': ['one = a:main', 'two = a:main']}"
    setup = f"import setuptools\nsetuptools.setup(py_modules=['a'], entry_points={entries})\n"
    (tmp_path / "setup.py").write_text(setup)
    (tmp_path / "a.py").write_text("def main(): print('started')\n")
    done = course("drive", tmp_path, *SHORT)
    assert (done.code, done.out) == (2, "")
    assert "which program is to be started?" in done.err
    assert "started" in course("drive", tmp_path / "two", *SHORT).out


def test_a_drive_that_ends_early_says_why(tmp_path: Path) -> None:
    node = tmp_path / "node.py"
    node.write_text("def main():\n    raise RuntimeError('as I said')\nmain()\n")
    done = course("drive", node, *SHORT)

    assert (done.code, done.err) == (1, "")
    assert "exception: RuntimeError: as I said (line 2, in main)" in done.out
    assert "created no publisher" in done.out
    assert str(tmp_path) not in done.out.split("What happened")[1]
