"""The engine alone, without the course: `pip install ./rclpy_virtual_time`.

pip installs the whole course by ../pyproject.toml and does not read this file. The portable runtime
comes along, with rclpy's Python.
"""

import sys
from pathlib import Path

from setuptools import find_packages, setup  # type: ignore[import-untyped]

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from rclpy_portable import unpacking  # noqa: E402

NAME, PORTABLE = HERE.name, "rclpy_portable"
ROS = ("rclpy", "common-interfaces", "rmw-fastrtps-cpp")
WHEELS = "sys_platform == 'linux' and platform_machine == 'x86_64' and python_version < '3.15'"

unpacking.folder(print)
setup(
    name="rclpy-virtual-time",
    version="0.1.0",
    description="Test unchanged rclpy programs in virtual time",
    long_description=(HERE / "README.md").read_text("utf-8"),
    long_description_content_type="text/markdown",
    license="Apache-2.0",
    python_requires=">=3.11",
    install_requires=[
        "msgspec", "numpy", "pytest", "pyyaml", "time-machine>=3,<3.7",
        *(f"ros-jazzy-{name}; {WHEELS}" for name in ROS),
    ],
    package_dir={NAME: f"../{NAME}", PORTABLE: f"../{PORTABLE}"},
    packages=[
        NAME, PORTABLE, f"{PORTABLE}.native",
        *(f"{NAME}.{each}" for each in find_packages(str(HERE), exclude=["tests*"])),
    ],
    package_data={
        f"{NAME}.host": ["real_time/*.xml"],
        f"{NAME}.conform": ["*.toml"],
        PORTABLE: ["_ros/**/*"],
    },
    entry_points={"pytest11": [f"{NAME} = {NAME}.testing.plugin"]},
    zip_safe=False,
)  # fmt: skip
