"""Drives of a node's text, and what is printed of them."""

import textwrap
from pathlib import Path

import pytest
from node_runs import PREAMBLE, short

from grader.course.submission import Submission
from grader.drive import drive_node, print_summary
from grader.recording import Recording
from rclpy_virtual_time.link.hosts import ForkServer


def drive_file(tmp_path: Path, forkserver: ForkServer, source: str, **options: object) -> Recording:
    file = tmp_path / "foreign.py"
    file.write_text(PREAMBLE + textwrap.dedent(source), "utf-8")
    return drive_node(Submission(file), short(1.0), forkserver, **options)  # type: ignore[arg-type]


def summary(recording: Recording, capsys: pytest.CaptureFixture[str]) -> str:
    capsys.readouterr()
    print_summary(recording, file="echo.py")
    return " ".join(capsys.readouterr().out.split())
