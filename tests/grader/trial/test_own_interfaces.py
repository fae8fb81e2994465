"""A package of interfaces beside the node's: its topics, services and actions are there."""

from pathlib import Path

import pytest
from command_line import ROOT, course
from laid_packages import lay

from grader.course.submission import find_submission

GROUP = "<member_of_group>rosidl_interface_packages</member_of_group>"
MANIFEST = f"<package><name>{{}}</name>{GROUP}</package>"
INTERFACES = {
    "our_types/package.xml": MANIFEST.format("our_types"),
    "our_types/CMakeLists.txt": """
        find_package(rosidl_default_generators REQUIRED)
        find_package(geometry_msgs REQUIRED)
        set(files "msg/Seen.msg" "srv/Ask.srv")  # "msg/Unlisted.msg"
        rosidl_generate_interfaces(${PROJECT_NAME} ${files} "action/Count.action"
            DEPENDENCIES geometry_msgs)
        """,
    "our_types/msg/Seen.msg": """
        uint8 NEAR=1   # closer than a metre
        std_msgs/Header header
        geometry_msgs/Point32[<=4] points
        float32[] distances
        float64[2] limits [0.5, 1.5]
        string<=8 word "none"
        string where
        """,
    "our_types/msg/Unlisted.msg": "bool a",
    "our_types/srv/Ask.srv": "Seen seen\n---\nbool far true\nstring why",
    "our_types/action/Count.action": "int32 to\n---\nint32[] all\n---\nour_types/Seen last",
}
NODE = """
    import rclpy
    from our_types.action import Count
    from our_types.msg import Seen
    from our_types.srv import Ask
    from rclpy.action import ActionClient, ActionServer
    from rclpy.callback_groups import ReentrantCallbackGroup
    from rclpy.node import Node
    from sensor_msgs.msg import LaserScan

    class Both(Node):
        def __init__(self):
            super().__init__("both")
            self.seen = self.create_publisher(Seen, "seen", 10)
            self.create_subscription(LaserScan, "/scan", self.hear, 10)
            group = ReentrantCallbackGroup()
            self.create_subscription(Seen, "seen", self.ask, 10, callback_group=group)
            self.create_service(Ask, "ask", lambda asked, _: Ask.Response(why=asked.seen.word))
            self.asked = self.create_client(Ask, "ask")
            self.server = ActionServer(self, Count, "count", self.count)
            self.counted = ActionClient(self, Count, "count")

        def hear(self, scan):
            self.seen.publish(Seen(header=scan.header, distances=scan.ranges[:3], word="lidar\\0 "))

        async def ask(self, seen):
            answer = await self.asked.call_async(Ask.Request(seen=seen))
            goal = await self.counted.send_goal_async(
                Count.Goal(to=3), lambda told: print("at", told.feedback.last.distances[0]))
            last = await goal.get_result_async()
            print("counted", answer.why, answer.far, *last.result.all)

        def count(self, goal):
            for i in range(goal.request.to):
                goal.publish_feedback(Count.Feedback(last=Seen(distances=[float(i)])))
            goal.succeed()
            return Count.Result(all=list(range(goal.request.to)))

    def main():
        rclpy.init()
        rclpy.spin(Both())
    """
ROBOT = {
    "robot/package.xml": MANIFEST.format("robot"),
    "robot/setup.py": """
        from setuptools import setup
        setup(name="robot", packages=["robot"],
              entry_points={"console_scripts": ["both = robot.both:main"]})
        """,
    "robot/robot/__init__.py": "",
    "robot/robot/both.py": NODE,
}


def drive(path: Path, *more: str) -> str:
    done = course("drive", path, "--scenario", "demo_wall", "--duration", "1", *more)
    assert (done.code in (0, 1), done.err) == (True, "")
    return " ".join(done.out.split())


@pytest.mark.parametrize("runtime", [(), ("--portable",)])
def test_topic_service_and_action_of_an_own_package(
    runtime: tuple[str, ...], tmp_path: Path
) -> None:
    said = drive(lay(tmp_path / "src", INTERFACES | ROBOT) / "robot", *runtime)
    assert "-> /seen our_types/msg/Seen reliable 10 messages" in said
    assert "<- /seen our_types/msg/Seen reliable up to 10 messages" in said
    assert "at 2.0" in said and "counted lidar True 0 1 2" in said
    assert "share/our_types/action/Count.action" in said  # came along
    assert "action server /count our_types/action/Count action client /count our_types/" in said


def test_a_workspace_that_is_handed_in_brings_them(tmp_path: Path) -> None:
    name, line = "obstacle_avoidance_agent", "from our_types.msg import Seen\nSeen.NEAR\n"
    agent = (ROOT / "solutions" / "obstacle_avoidance" / f"{name}.py").read_text("utf-8")
    graded = INTERFACES | ROBOT | {f"robot/robot/{name}.py": line + agent}
    graded["robot/setup.py"] = ROBOT["robot/setup.py"].replace("both", name)
    done = course("grade", "1", lay(tmp_path, graded), "--only", "wiring", "--json", "-")
    assert 0 < done.json["score"] == done.json["max_score"], done.err
    alone = find_submission(tmp_path / "robot", f"{name}.py")  # what lies around may be another's
    assert not any("our_types" in file for file in alone.files)


@pytest.mark.parametrize("runtime", [(), ("--portable",)])
def test_the_tutorials_interfaces_are_there(runtime: tuple[str, ...], tmp_path: Path) -> None:
    node = """
    import rclpy
    from example_interfaces.action import Fibonacci
    from example_interfaces.srv import AddTwoInts
    rclpy.init()
    node = rclpy.create_node("sum")
    node.create_service(AddTwoInts, "add", lambda q, r: AddTwoInts.Response(sum=q.a + q.b))
    future = node.create_client(AddTwoInts, "add").call_async(AddTwoInts.Request(a=2, b=40))
    rclpy.spin_until_future_complete(node, future)
    print("sum", future.result().sum, Fibonacci.Goal(order=7).order)
    """
    assert "sum 42 7" in drive(lay(tmp_path, {"node.py": node}) / "node.py", *runtime)


def test_a_file_takes_a_folder_beside_it(tmp_path: Path) -> None:
    line = "from our_types.msg import Seen\nprint(Seen().limits, Seen.NEAR)\n"
    assert "[0.5 1.5] 1" in drive(lay(tmp_path, {**INTERFACES, "node.py": line}) / "node.py")


@pytest.mark.parametrize(
    ("file", "before", "after", "expected"),
    [
        ("CMakeLists.txt", "rosidl_default_generators", "", "wants find_package(rosidl_default_g"),
        ("CMakeLists.txt", "DEPENDENCIES geometry_msgs", "", "D) and DEPENDENCIES geometry_msgs."),
        ("CMakeLists.txt", "rosidl_generate", "gen", "has no rosidl_generate_interfaces(…)."),
        ("CMakeLists.txt", "Ask", "Task", "names srv/Task.srv, but there is no such file."),
        ("package.xml", GROUP, "", f"package.xml lacks {GROUP}."),
        ("package.xml", "our_", "our-", "expected a <name> of small letters, digits and _."),
    ],
)
def test_what_colcon_would_not_build_is_said_in_a_line(
    file: str, before: str, after: str, expected: str, tmp_path: Path
) -> None:
    wrong = {f"our_types/{file}": INTERFACES[f"our_types/{file}"].replace(before, after)}
    lay(tmp_path, INTERFACES | ROBOT | {"node.py": "a"})
    for path, files, count in (("node.py", {}, 0), ("node.py", wrong, 1), ("robot", {}, 1)):
        found = find_submission(lay(tmp_path, files) / path)
        stops = [line for line in found.account() if line.startswith("On a robot colcon build")]
        assert len(stops) == count and all(expected in line for line in stops)
        assert path == "robot" or not any("Unlisted" in name for name in found.files)


@pytest.mark.parametrize(
    ("file", "text", "line", "expected"),
    [
        (
            "msg/Seen.msg",
            "bool a\nflot b",
            "msg import Seen",
            "Seen.msg, line 2: 'flot b': there is no such type",
        ),
        ("srv/Ask.srv", "bool a", "srv import Ask", "our_types/srv/Ask.srv: expected 1 line ---"),
        ("msg/Seen.msg", "nav2_msgs/Costmap a", "msg import Seen", "lay the folder nav2_msgs from"),
        (
            "msg/Seen.msg",
            "bool a",
            "msg import Unlisted",
            "has no Unlisted: its folder doesn't, or",
        ),
        (
            "CMakeLists.txt",
            "rosidl_generate_interfaces(our_types msg/Seen.msg)",
            "srv import Ask",
            "our_types.srv has no Ask: its folder doesn't, or",
        ),
        ("msg/Seen.msg", "bool a", "other import Seen", "No module named 'our_types.other'"),
    ],
)
def test_what_is_wrong_is_said_with_file_and_line(
    file: str, text: str, line: str, expected: str, tmp_path: Path
) -> None:
    wrong = INTERFACES | ROBOT | {f"our_types/{file}": text}
    wrong |= {"robot/robot/both.py": f"from our_types.{line}\ndef main(): ..."}
    said = drive(lay(tmp_path, wrong) / "robot")
    assert expected in said
    said = said.partition("On a robot")[0]
    assert "colcon" not in said and "lay the folder our_types" not in said
