"""A colcon package of two nodes, and a folder to lay it in."""

import textwrap
from collections.abc import Mapping
from pathlib import Path

XML = "<package><name>mine</name></package>"
SETUP = """
    import os
    from glob import glob
    from setuptools import find_packages, setup
    setup(name="mine", packages=find_packages(exclude=["test"]),
          data_files=[(os.path.join("share", "mine", "config"), glob("config/*.yaml")),
                      (os.path.join("share", "mine"), glob("launch/*.py"))],
          entry_points={"console_scripts": ["one = mine.one:main", "two = mine.two:main"]})
    """
NODE = """
    import rclpy
    from rclpy.node import Node
    from mine.common import counted

    def main(args=None):
        rclpy.init(args=args)
        node = Node("node")
        node.declare_parameter("word", "none")
        print(__name__, node.get_name(), node.get_parameter("word").value, counted())
        rclpy.spin(node)
    """
COMMON = "SEEN = []\ndef counted():\n    SEEN.append(1)\n    return len(SEEN)\n"
LAUNCH = """
    from ament_index_python.packages import get_package_share_directory
    from launch import LaunchDescription
    from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
    from launch.launch_description_sources import PythonLaunchDescriptionSource
    from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
    from launch_ros.actions import Node
    from launch_ros.substitutions import FindPackageShare

    def generate_launch_description():
        share = get_package_share_directory("mine")
        return LaunchDescription([
            DeclareLaunchArgument("name", default_value="first"),
            Node(package="mine", executable="one", name=LaunchConfiguration("name"),
                 parameters=[PathJoinSubstitution([FindPackageShare("mine"), "config", "p.yaml"])]),
            Node(package="rviz2", executable="rviz2"),
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(share + "/inner.launch.py"),
                launch_arguments={"word": "7"}.items()),
        ])
    """
INNER = """
    from launch import LaunchDescription
    from launch.actions import DeclareLaunchArgument
    from launch.substitutions import LaunchConfiguration
    from launch_ros.actions import Node

    def generate_launch_description():
        return LaunchDescription([
            DeclareLaunchArgument("word"),
            Node(executable="two", package="mine",
                 parameters=[{"word": ["n", LaunchConfiguration("word")]}])])
    """
MINE = {
    "package.xml": XML,
    "setup.py": SETUP,
    "mine/__init__.py": "",
    "mine/common.py": COMMON,
    "mine/one.py": NODE,
    "mine/two.py": NODE.replace("mine.common", ".common"),
    "config/p.yaml": "first:\n  ros__parameters:\n    word: shared\n",
}


def lay(folder: Path, files: Mapping[str, str]) -> Path:
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(textwrap.dedent(text))
    return folder
