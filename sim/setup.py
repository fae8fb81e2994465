"""course_sim, the mock robot as a ROS package: what `colcon build` reads.

pip installs the whole course by ../pyproject.toml and does not read this file.
"""

from pathlib import Path

from setuptools import find_packages, setup  # type: ignore[import-untyped]

NAME = "course_sim"
HERE = Path(__file__).resolve().parent  # colcon may run a link to this file
EXERCISES = {  # a package of the robot's for each exercise's scenarios, which lie with its judge
    f"sim.scenarios.{folder.parent.name}": f"../grader/exercises/{folder.parent.name}/scenarios"
    for folder in sorted((HERE.parent / "grader" / "exercises").glob("*/scenarios"))
}

setup(
    name=NAME,
    version="1.0.0",
    description="The mock robot of the course: lidar, odometry and motors on ROS 2 topics",
    license="Apache-2.0",
    # This folder is the package. By "." colcon build --symlink-install would not find it.
    package_dir={"sim": f"../{HERE.name}", **EXERCISES},
    packages=["sim", *(f"sim.{name}" for name in find_packages(str(HERE))), *EXERCISES],
    package_data={
        "sim": ["worlds/*.toml", "scenarios/*/*.toml"],
        **{package: ["*.toml"] for package in EXERCISES},
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", ["launch/sim.launch.py"]),
    ],
    entry_points={"console_scripts": ["mock_robot = sim.live.cli:main"]},
    zip_safe=False,
)
