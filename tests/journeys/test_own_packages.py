"""Packages of people's own: one of `ros2 pkg create`, and one like those that are public."""

import pytest
from person import ROOT, Person

MINE = "my_robot/config/mine.yaml"
# ros2 pkg create --build-type ament_python --node-name live_parameters_agent my_robot
CREATED = {
    "my_robot/package.xml": """
        <?xml version="1.0"?>
        <?xml-model href="http://download.ros.org/schema/package_format3.xsd"?>
        <package format="3">
          <name>my_robot</name> <version>0.0.0</version>
          <description>TODO: Package description</description>
          <maintainer email="ada@todo.todo">ada</maintainer>
          <license>TODO: License declaration</license>
          <test_depend>ament_copyright</test_depend>
          <export> <build_type>ament_python</build_type> </export>
        </package>
        """,
    "my_robot/setup.cfg": "[develop]\nscript_dir=$base/lib/my_robot\n",
    "my_robot/setup.py": """
        from glob import glob
        from setuptools import find_packages, setup

        package_name = 'my_robot'

        setup(
            name=package_name,
            version='0.0.0',
            packages=find_packages(exclude=['test']),
            data_files=[
                ('share/ament_index/resource_index/packages', ['resource/' + package_name]),
                ('share/' + package_name, ['package.xml']),
                ('share/' + package_name + '/launch', glob('launch/*launch.[pxy][yma]*')),
                ('share/' + package_name + '/config', glob('config/*.yaml')),
            ],
            install_requires=['setuptools'],
            zip_safe=True,
            tests_require=['pytest'],
            entry_points={'console_scripts': [
                'live_parameters_agent = my_robot.live_parameters_agent:main'
            ]},
        )
        """,
    "my_robot/resource/my_robot": "",
    "my_robot/my_robot/__init__.py": "",
    "my_robot/test/test_copyright.py": "from ament_copyright.main import main\n",
    "my_robot/launch/robot.launch.py": """
        import os
        from ament_index_python.packages import get_package_share_directory
        from launch import LaunchDescription
        from launch_ros.actions import Node

        def generate_launch_description():
            share = get_package_share_directory('my_robot')
            return LaunchDescription([Node(
                package='my_robot', executable='live_parameters_agent',
                parameters=[{'use_sim_time': False}, os.path.join(share, 'config', 'mine.yaml')])])
        """,
    MINE: """
        /**:
          ros__parameters: {cruise_speed: 0.2}
        live_parameters_agent:
          ros__parameters: {stop_distance: 0.9}
        """,
}
PUBLIC = {
    "src/wall_interfaces/package.xml": """
        <package format="3"><name>wall_interfaces</name><version>0.1.2</version>
          <buildtool_depend>rosidl_default_generators</buildtool_depend>
          <depend>std_msgs</depend>
          <member_of_group>rosidl_interface_packages</member_of_group>
          <export><build_type>ament_cmake</build_type></export></package>
        """,
    "src/wall_interfaces/CMakeLists.txt": """
        cmake_minimum_required(VERSION 3.8)
        project(wall_interfaces)
        find_package(rosidl_default_generators REQUIRED)
        find_package(std_msgs REQUIRED)
        set(msg_files "msg/Wall.msg")
        rosidl_generate_interfaces(${PROJECT_NAME} ${msg_files} DEPENDENCIES std_msgs)
        """,
    "src/wall_interfaces/msg/Wall.msg": "std_msgs/Header header\nfloat32 distance  # [m]\n",
    "src/wall_follower/package.xml": """
        <package format="3"><name>wall_follower</name><version>0.1.2</version>
          <depend>wall_interfaces</depend>
          <export><build_type>ament_python</build_type></export></package>
        """,
    "src/wall_follower/setup.py": """
        import os
        from glob import glob
        from setuptools import setup
        package_name = "wall_follower"
        setup(
            name=package_name, version="0.1.2", packages=[package_name],
            data_files=[(os.path.join("share", package_name), ["package.xml"]),
                        (os.path.join("share", package_name, "launch"), glob("launch/*.py"))],
            entry_points={"console_scripts": ["follower = wall_follower.follower:main"]})
        """,
    "src/wall_follower/wall_follower/__init__.py": "",
    "src/wall_follower/wall_follower/control.py": """
        def turn(side, error, gain=0.8):
            return side * gain * error
        """,
    "src/wall_follower/wall_follower/follower.py": """
        #!/usr/bin/env python3
        import math
        import rclpy
        from geometry_msgs.msg import TwistStamped
        from rclpy.node import Node
        from sensor_msgs.msg import LaserScan
        from wall_interfaces.msg import Wall
        from .control import turn

        class WallFollower(Node):
            def __init__(self):
                super().__init__("wall_follower")
                self.declare_parameters("", [("scan_topic", "laser/scan"), ("speed", 0.25)])
                self.side, self.scan = -1, None
                topic = self.get_parameter("scan_topic").get_parameter_value().string_value
                self.create_subscription(LaserScan, topic, self.on_scan, 1)
                self.drive = self.create_publisher(TwistStamped, "drive", 1)
                self.wall = self.create_publisher(Wall, "~/wall", 10)
                self.create_timer(0.1, self.control)

            def on_scan(self, msg):
                self.scan = msg

            def control(self):
                if self.scan is None:
                    return
                beside = self.side * math.pi / 2 - self.scan.angle_min
                distance = self.scan.ranges[int(beside / self.scan.angle_increment)]
                self.wall.publish(Wall(header=self.scan.header, distance=distance))
                msg = TwistStamped()
                msg.header.stamp = self.get_clock().now().to_msg()
                msg.twist.linear.x = self.get_parameter("speed").value
                if math.isfinite(distance):
                    msg.twist.angular.z = turn(self.side, distance - 1.0)
                self.drive.publish(msg)

        def main(args=None):
            rclpy.init(args=args)
            rclpy.spin(WallFollower())
        """,
    "src/wall_follower/launch/demo.launch.py": """
        from launch import LaunchDescription
        from launch_ros.actions import Node

        def generate_launch_description():
            return LaunchDescription([
                Node(package="wall_follower", executable="follower", output="screen",
                     remappings=[("laser/scan", "/scan"), ("drive", "/cmd_vel")])])
        """,
}


def test_a_launch_file_with_a_parameter_file(person: Person) -> None:
    """It arrives in the node; and a scenario that asks for parameters gets them all the same."""
    node = ROOT / "solutions" / "live_parameters" / "live_parameters_agent.py"
    person.writes(CREATED)
    person.writes({"my_robot/my_robot/live_parameters_agent.py": node.read_text("utf-8")})
    said = person.types("course drive my_robot/launch/robot.launch.py --scenario demo_wall")
    assert "fastest 0.20 m/s" in said
    assert "nearest to an obstacle: 0.72 m" in said
    defaults = (ROOT / "exercises" / "config" / "live_parameters.yaml").read_text("utf-8")
    person.writes({MINE: f"/**: {{ros__parameters: {{use_sim_time: false}}}}\n{defaults}"})
    assert "Score  100 / 100" in person.types("course grade 10 my_robot")


@pytest.mark.parametrize("runtime", ["", "--portable"])
def test_interfaces_of_its_own(person: Person, runtime: str) -> None:
    person.writes(PUBLIC)
    drive = "course drive src/wall_follower/launch/demo.launch.py --scenario demo_store"
    said = " ".join(person.types(f"{drive} --duration 20 {runtime}").split())
    assert "-> /wall_follower/wall wall_interfaces/msg/Wall reliable 199 messages" in said
    assert "-> /cmd_vel geometry_msgs/msg/TwistStamped reliable 199 messages" in said
    assert ("practice: your instructor" in said) == bool(runtime)
    assert "Left behind" not in said
