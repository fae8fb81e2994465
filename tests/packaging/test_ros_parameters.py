"""The parameter files, read by the real rclpy, arrive in the reference solutions' nodes."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import yaml

from grader.course.exercises import ROOT, all_exercises

CONFIG = ROOT / "exercises" / "config"
FILES = sorted(CONFIG.glob("*.yaml"))
# Makes the nodes [[solution, node's name, parameter file], …] and says what their parameters are.
ASK = """
import importlib.util, json, sys
from pathlib import Path
import rclpy
from rclpy.node import Node

answers = []
for number, (solution, name, file) in enumerate(json.load(sys.stdin)):
    sys.path.insert(0, str(Path(solution).parent))
    spec = importlib.util.spec_from_file_location(f"solution_{number}", solution)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    rename = ["-r", f"__node:={name}"] if name else []
    rclpy.init(args=["--ros-args", *rename, "--params-file", file])
    classes = [c for c in vars(module).values() if isinstance(c, type) and issubclass(c, Node)]
    (cls,) = [c for c in classes if c is not Node]
    node = cls()
    own = {k: v for k, v in node.get_parameters_by_prefix("").items()
           if k not in ("use_sim_time", "start_type_description_service")}
    answers.append({"node": node.get_name(), "parameters": {k: v.value for k, v in own.items()}})
    node.destroy_node()
    rclpy.shutdown()
print("ANSWERS" + json.dumps(answers))
"""
Parameters = dict[str, Any]


def parameters_of(file: Path) -> dict[str, Parameters]:
    """Return node: its parameters."""
    content = yaml.safe_load(file.read_text("utf-8"))
    return {node: tables["ros__parameters"] for node, tables in content.items()}


def solution_of(slug: str, node: str) -> tuple[Path, str]:
    """Return the reference that has this node, and how it is renamed ("" if it is its own)."""
    exercise = next(each for each in all_exercises() if each.slug == slug)
    file = "detection_client.py" if node.endswith("_client") else f"{node}.py"
    assert file in exercise.files, f"{slug} has no node {node}"
    return exercise.solutions / file, node if file != f"{node}.py" else ""


def ask(*nodes: tuple[Path, str, Path]) -> list[dict[str, Any]]:
    """Start each node (solution, name, parameter file) and ask it for its parameters."""
    done = subprocess.run(
        [sys.executable, "-c", ASK],
        input=json.dumps([[str(part) for part in node] for node in nodes]),
        env=os.environ | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"},
        capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    answers: list[dict[str, Any]] = json.loads(done.stdout.rpartition("ANSWERS")[2])
    return answers


def others(values: Parameters) -> Parameters:
    """Return other values of the same types: no node has them by default."""
    return {
        name: value * 0.9 if isinstance(value, float) else f"other_{value}"
        for name, value in values.items()
    }


def test_every_node_with_parameters_has_its_file() -> None:
    nodes = {node for file in FILES for node in parameters_of(file)}
    assert {file.stem for file in FILES} <= {exercise.slug for exercise in all_exercises()}
    for exercise in all_exercises():
        if exercise.files[0].endswith("launch.py"):
            continue  # which has them
        for file in exercise.files:
            source = (exercise.solutions / file).read_text("utf-8")
            if "declare_parameter(" in source and file != "detection_client.py":
                where = f"exercises/config/{exercise.slug}.yaml: {file} declares parameters"
                assert Path(file).stem in nodes, where
    assert {"navigation_client", "manipulation_client", "logging_client"} <= nodes


def test_parameters_arrive_in_the_nodes(tmp_path: Path) -> None:
    """What the files say, and that it is not the defaults that are seen."""
    asked, expected = [], []
    for file in FILES:
        changed = tmp_path / file.name
        made = {}
        for node, values in parameters_of(file).items():
            solution, rename = solution_of(file.stem, node)
            made[node] = {"ros__parameters": others(values)}
            asked += [(solution, rename, file), (solution, rename, changed)]
            expected += [
                {"node": node, "parameters": values},
                {"node": node, "parameters": others(values)},
            ]
        changed.write_text(yaml.safe_dump(made), "utf-8")
    assert ask(*asked) == expected
