"""A notebook as students get it, from its first cell, which installs the course, to a check."""

import json
from pathlib import Path

import pytest
from person import ROOT, Person, can_mount, environment

FILE = "obstacle_avoidance_agent.py"
SOLUTION = (ROOT / "solutions" / "obstacle_avoidance" / FILE).read_text("utf-8")
HERE = "jupyter execute --inplace 01_loop.ipynb"
# Debian's own Python, as on Colab: pip puts wheels where it puts them there; no compiler
BARE = f"""
set -e
export PATH=/usr/local/bin:/usr/bin:/bin PIP_NO_CACHE_DIR=1
mount --make-rprivate /
mount -t tmpfs tmpfs layers
mkdir layers/upper layers/work
mount -t overlay overlay -o lowerdir=/usr,upperdir=layers/upper,workdir=layers/work /usr
python3 -m pip install --quiet --break-system-packages ipykernel nbclient
rm -f /usr/bin/*gcc* /usr/bin/*g++* /usr/bin/cc /usr/bin/c++
{HERE} --timeout=600
"""


@pytest.mark.long
@pytest.mark.parametrize("pip", ["from the network", ""])
def test_from_the_first_cell_to_a_check(
    instructors: Path, wheel: Path, tmp_path: Path, pip: str
) -> None:
    if pip and not can_mount():
        pytest.skip("an overlay over /usr needs a mount namespace: root")
    notebook = json.loads((instructors / "release/01_loop/01_loop.ipynb").read_text("utf-8"))
    texts = ["".join(cell["source"]) for cell in notebook["cells"]]
    first_check = next(n for n, text in enumerate(texts) if text.startswith("check("))
    del notebook["cells"][first_check + 1 :]
    place = next(n for n, text in enumerate(texts) if text.startswith(f"%%node {FILE}"))
    notebook["cells"][place]["source"] = f"%%node {FILE}\n{SOLUTION}"
    student = Person(tmp_path)
    student.writes({"01_loop.ipynb": json.dumps(notebook)})
    (tmp_path / wheel.name).write_bytes(wheel.read_bytes())
    if pip:
        student.types(f"mkdir layers; {BARE}", before="unshare --mount")
    else:
        tools = ("ipykernel", "nbclient", "matplotlib", "pip")
        env = environment(tmp_path / "env", "", ("ros", "ml"), tools)
        Person(tmp_path, env).types(HERE)
    said = json.loads((tmp_path / "01_loop.ipynb").read_text("utf-8"))["cells"]
    shown = {n: json.dumps(cell["outputs"], ensure_ascii=False)
             for n, cell in enumerate(said) if cell["cell_type"] == "code"}  # fmt: skip
    assert "Ready: " in next(iter(shown.values()))
    assert f"Saved {FILE}" in shown[place]
    assert shown[first_check].count("✓ pass") >= 3
    assert "FAIL" not in shown[first_check]
