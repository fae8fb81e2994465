"""The names of the package: each is there, at most forty, and told in the README."""

import re
import subprocess
import sys
from pathlib import Path

import rclpy_virtual_time

README = Path(rclpy_virtual_time.__file__).with_name("README.md").read_text("utf-8")


def test_each_name_is_there_and_in_the_readme() -> None:
    names = rclpy_virtual_time.__all__
    assert len(names) <= 40
    for name in names:
        assert getattr(rclpy_virtual_time, name) is not None
        assert f"`{name}`" in README


def test_a_host_imports_none_of_the_callers_side() -> None:
    """The package's own `__init__` is the first that a host imports: it must stay small."""
    code = "import sys, rclpy_virtual_time; print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    ours = re.findall(r"rclpy_virtual_time[\w.]*", loaded.stdout)
    assert ours == ["rclpy_virtual_time"]
