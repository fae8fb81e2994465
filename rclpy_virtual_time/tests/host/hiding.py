"""Advice that names the file which hides a module."""

from rclpy_virtual_time import Advice


class Hiding(Advice):
    def hint(self, error: BaseException) -> str:
        return (file := self.hiding_file(error)) and f"hidden by {file}"
