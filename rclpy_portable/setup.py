"""rclpy_portable alone, without the course: `pip install ./rclpy_portable`.

pip installs the whole course by ../pyproject.toml and does not read this file.
"""

import sys
from pathlib import Path

from setuptools import setup  # type: ignore[import-untyped]

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from rclpy_portable import unpacking  # noqa: E402

unpacking.folder(print)
setup(
    name="rclpy-portable",
    version="1.0.0",
    description="The real rclpy without ROS: its own Python over a native half in Python",
    license="Apache-2.0",
    python_requires=">=3.11",
    install_requires=["numpy", "pyyaml"],
    package_dir={"rclpy_portable": f"../{HERE.name}"},
    packages=["rclpy_portable", "rclpy_portable.native"],
    package_data={"rclpy_portable": ["_ros/**/*"]},
    zip_safe=False,
)
