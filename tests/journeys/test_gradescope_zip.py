"""Gradescope's zip: unpacked into its folders, its scripts run, a submission judged."""

import json
from pathlib import Path

import pytest
from person import INSTRUCTOR, ROOT, Person, can_mount, environment

FILE = "live_parameters_agent.py"
# Gradescope's container: a root of its own with /autograder in it
CONTAINER = """
set -e
mount --make-rprivate /
mount -t tmpfs tmpfs layers
mkdir layers/upper layers/work layers/root
mount -t overlay overlay -o lowerdir=/,upperdir=layers/upper,workdir=layers/work layers/root
for each in dev proc sys tmp; do mount --rbind /$each layers/root/$each; done
mkdir layers/root/autograder
mount --bind . layers/root/autograder
/usr/sbin/chroot layers/root sh -ec "cd /autograder; bash source/setup.sh; ./run_autograder"
"""


@pytest.mark.parametrize("pip", [pytest.param("from the network", marks=pytest.mark.long), ""])
def test_a_submission_is_judged(tmp_path: Path, pip: str) -> None:
    if pip and not can_mount():
        pytest.skip("a root of its own needs a mount namespace: root")
    secret = "head -c 24 /dev/urandom | base64 > secret; "
    line = "course release upload --gradescope --exercise 10 --secret secret"
    assert "autograder points: 100" in Person(tmp_path, INSTRUCTOR).types(secret + line)

    there = Person(tmp_path)
    there.types("unzip -q upload/autograder.zip -d source; cp source/run_autograder .")
    there.types("mkdir results layers")
    there.writes({f"submission/{FILE}": (ROOT / "solutions/live_parameters" / FILE).read_text()})
    about = {"users": [{"id": 5, "name": "Ann Lee", "email": "ann@example.org"}]}
    there.writes({"submission_metadata.json": json.dumps(about)})
    if pip:
        said = there.types(CONTAINER, before="unshare --mount")
    else:
        environment(tmp_path / "opt" / "venv", f"--editable {tmp_path / 'source' / 'course'}")
        said = there.types("AUTOGRADER_ROOT=$PWD COURSE_HOME=$PWD/opt ./run_autograder")
    assert "100 points" in said
    found = json.loads((tmp_path / "results" / "results.json").read_text("utf-8"))
    assert found["score"] == 100
    assert {each["status"] for each in found["tests"]} == {"passed"}
