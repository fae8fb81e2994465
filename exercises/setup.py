"""course_exercises, a student's nodes as a ROS package: what `colcon build` reads.

Every file that an `exercise.toml` names becomes a program of that name:
`ros2 run course_exercises PROGRAM`; but launch files are for `ros2 launch course_exercises FILE`.
Edit the files where they are.
"""

import tomllib
from pathlib import Path

from setuptools import setup

NAME = "course_exercises"
HERE = Path(__file__).resolve().parent  # colcon may run a link to this file

NODES = {  # program: module
    Path(file).stem: f"{NAME}.{about.parent.name}.{Path(file).stem}"
    for about in sorted(HERE.glob("*/exercise.toml"))
    for file in tomllib.loads(about.read_text("utf-8"))["files"]
    if not file.endswith("launch.py")
}
FOLDERS = sorted({module.rpartition(".")[0] for module in NODES.values()})


def shared(folder: str, pattern: str) -> tuple[str, list[str]]:
    """Return where a folder's files are installed, and which they are."""
    files = sorted(HERE.glob(f"{folder}/{pattern}"))
    return f"share/{NAME}/{folder}", [f"{folder}/{file.name}" for file in files]


setup(
    name=NAME,
    version="1.0.0",
    description="The exercises of the course: a student's nodes, launch files and parameters",
    license="Apache-2.0",
    # This folder is the package. By "." colcon build --symlink-install would not find it.
    package_dir={NAME: f"../{HERE.name}"},
    packages=[NAME, *FOLDERS],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        shared("launch", "*.launch.py"),
        *(shared(about.parent.name, "*launch.py") for about in HERE.glob("*/exercise.toml")),
        *(shared(about.parent.name, about.name) for about in HERE.glob("*/exercise.toml")),
        shared("config", "*.yaml"),
        shared("rviz", "*.rviz"),
    ],
    entry_points={
        "console_scripts": [f"{program} = {module}:main" for program, module in NODES.items()]
    },
    zip_safe=False,
)
