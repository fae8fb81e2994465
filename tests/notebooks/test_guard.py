"""A cell that would spin in the kernel is caught before it runs; nothing else is."""

import ast
from pathlib import Path

import pytest
from kernels import Kernel

from grader.notebook.build import all_notebooks, built, text_of
from grader.notebook.guard import SpinGuard
from grader.notebook.session import SESSION

NODE = """
import rclpy
from rclpy.node import Node

class Agent(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")

def main():
    rclpy.init()
    rclpy.spin(Agent())

if __name__ == "__main__":
    main()
"""
SPINS = {
    "main": NODE,
    "at once": "import rclpy\nrclpy.spin(node)",
    "imported": "from rclpy import spin\nspin(node)",
    "an executor": "executor.add_node(node)\nexecutor.spin()",
    "through another": "def run():\n    rclpy.spin(x)\ndef main():\n    run()\nmain()",
    "in a loop of its own": "while rclpy.ok():\n    rclpy.spin_once(node, timeout_sec=1.0)",
    "whatever its loop": NODE.replace("rclpy.spin(Agent())", "Agent().run_for_ever()"),
    "in a try": "try:\n    rclpy.spin(node)\nfinally:\n    pass",
}
FINE = {
    "only defined": NODE.partition("if __name__")[0],
    "in a thread": "Thread(target=executor.spin).start()",
    "once": "rclpy.spin_once(node, timeout_sec=0.1)",
    "until it is done": "while not future.done():\n    rclpy.spin_once(node, timeout_sec=0.1)",
    "another main": "def main():\n    print(1)\nmain()",
    "later": "run = lambda: rclpy.spin(node)",
    "a word": "print('rclpy.spin(node)')",
}


@pytest.fixture(autouse=True)
def _fresh(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(SESSION, "refused", {})


def refused(guard: SpinGuard, cell: str) -> str:
    try:
        guard.visit(ast.parse(cell))
    except Exception as error:
        return str(error)
    return ""


@pytest.mark.parametrize("how", [*SPINS, *FINE])
def test_a_cell_that_would_spin_is_refused_and_no_other(how: str) -> None:
    said = refused(SpinGuard(), (SPINS | FINE)[how])
    assert ("Is its first line missing? With “%%node" in said) == (how in SPINS)
    assert bool(said) == (how in SPINS)


def test_no_node_cell_that_is_handed_out_runs_without_its_first_line() -> None:
    cells = [cell.source for name in all_notebooks() for cell in built(text_of(name)).cells]
    nodes = [cell for cell in cells if cell.startswith("%%node") and "import rclpy" in cell]
    assert len(nodes) >= 10
    for cell in nodes:
        first, rest = cell.split("\n", 1)
        assert refused(SpinGuard(), rest), first


def test_a_function_of_an_earlier_cell_counts_until_it_is_another() -> None:
    guard = SpinGuard()
    assert refused(guard, FINE["only defined"]) == ""
    assert refused(guard, "main()")
    assert refused(guard, FINE["another main"]) == ""
    assert refused(guard, "main()") == ""


def test_the_kernel_goes_on_and_check_knows_of_the_cell(kernel: Kernel, folder: Path) -> None:
    name = "obstacle_avoidance_agent.py"
    kernel.run(f"%%node {name}\n{NODE}")
    said = kernel.run(NODE)

    assert said.status == "error"
    assert said.traceback.splitlines() == [
        "Not run: this cell would spin its node in the notebook itself, and never come back.",
        f"Is its first line missing? With “%%node {name}” above it, the cell becomes that file, "
        "and drive() and check() run it.",
    ]
    checked = kernel.run("check('1')").stdout
    assert checked.startswith(f"Not checked: the last %%node {name} cell was not saved (its first")
    assert kernel.run("print(6 * 7)").stdout == "42\n"
    (folder / name).unlink()
