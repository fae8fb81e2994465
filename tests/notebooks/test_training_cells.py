"""`dataset` and `train` in a real kernel."""

from pathlib import Path

import numpy as np
from kernels import Kernel, save

from grader.models.dataset import make_dataset

SCRIPT = "train_velocity_model.py"
QUICK = """\
import argparse, pathlib
parser = argparse.ArgumentParser()
for name in ("--data", "--out", "--onnx"):
    parser.add_argument(name)
given = parser.parse_args()
assert pathlib.Path(given.data).is_file()
print("epoch 1", flush=True)
pathlib.Path(given.out).write_bytes(b"model")
pathlib.Path(given.onnx).write_bytes(b"the same")
"""
STUCK = "print('epoch 1', flush=True)\nimport threading\nthreading.Event().wait()\n"
RED = "\x1b[31m"
HOSTILE = f"{RED}<script>alert(1)</script>"


def test_the_data_are_those_of_the_command(kernel: Kernel, folder: Path) -> None:
    said = kernel.run("data = dataset('small.npz', scans=100, seed=3)\ndata")
    assert said.text.strip().startswith("small.npz: 100 scans of one room; in ")
    with np.load(folder / "small.npz") as file:
        made = make_dataset(100, 3)
        np.testing.assert_array_equal(file["ranges"], made.ranges)
        np.testing.assert_array_equal(file["speed"], made.speed)
        np.testing.assert_array_equal(file["room"], made.room)
    kernel.run("shapes = [a.shape for a in (data.ranges, data.speed, data.room, data.angles)]")
    shapes = kernel.run("print(*shapes)")
    assert shapes.stdout == "(100, 360) (100,) (100,) (360,)\n"
    assert kernel.run("show_features(data.scan(0));").traceback == ""


def test_wrong_data_are_refused_in_a_sentence(kernel: Kernel) -> None:
    for cell, expected in {
        "dataset('small.csv')": "expected a name that ends in .npz",
        "dataset('small.npz', scans=5)": "expected 100 to 100000",
        "dataset('small.npz', seed=-1)": "expected 0 or more",
        "dataset('nowhere/small.npz', scans=100)": "No such file or directory",
    }.items():
        said = kernel.run(cell)
        assert expected in said.traceback
        assert "\n" not in said.traceback


def test_training_shows_output_and_what_was_written(kernel: Kernel, folder: Path) -> None:
    save(kernel, SCRIPT, QUICK)
    kernel.run("dataset(scans=100)")
    said = kernel.run("done = train()\nprint(done)")
    assert said.stdout == "True\n"
    assert "epoch 1" in said.displays[0]["text/plain"]
    assert "✓ velocity_model.pkl: 5 bytes" in said.text
    assert "✓ velocity_model.onnx: 8 bytes" in said.text
    assert (folder / "velocity_model.pkl").read_bytes() == b"model"
    assert said.stderr == ""


def test_a_failing_script_leaves_no_model_of_an_earlier_one(kernel: Kernel, folder: Path) -> None:
    (folder / "velocity_model.pkl").write_bytes(b"old")
    save(kernel, SCRIPT, f"raise ValueError({HOSTILE!r})\n")
    said = kernel.run("print(train())")
    assert said.stdout == "False\n"
    assert "Not trained: train_velocity_model.py failed after" in said.text
    assert "(exit code 1)" in said.text
    assert f"ValueError: {HOSTILE.removeprefix(RED)}" in said.text
    assert "<script" not in said.html
    assert not (folder / "velocity_model.pkl").exists()


def test_a_script_that_writes_nothing_is_noticed(kernel: Kernel) -> None:
    save(kernel, SCRIPT, "x = 1\n")
    said = kernel.run("print(train())")
    assert said.stdout == "False\n"
    assert "✗ velocity_model.pkl: was not written" in said.text


def test_the_stop_button_ends_the_script(kernel: Kernel) -> None:
    save(kernel, SCRIPT, STUCK)
    said = kernel.run("print(train())", when=lambda said: "epoch 1" in said.html)
    assert said.stdout == "False\n"
    assert "Not trained: stopped, because you interrupted the kernel" in said.text


def test_a_script_that_is_not_there_or_was_not_saved(kernel: Kernel, folder: Path) -> None:
    (folder / SCRIPT).unlink(missing_ok=True)
    assert f"run the cell that starts with “%%node {SCRIPT}” first" in kernel.run("train()").text
    kernel.run(f"%%node {SCRIPT}\nx = (\n")
    assert "cell was not saved (line 1: '(' was never closed)" in kernel.run("train()").text
    save(kernel, SCRIPT, QUICK)
