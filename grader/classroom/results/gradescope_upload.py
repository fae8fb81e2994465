"""The way of a class's results into Gradescope: an autograder that only looks them up.

Upload `gradescope/autograder.zip` to the programming assignments that the submissions were exported
from, and choose "Regrade all submissions". No student's code runs there.

Source: Gradescope, "Autograder Specifications" and "Submission Metadata": the zip holds `setup.sh`
and `run_autograder` and is unpacked to /autograder/source; `id` in
/autograder/submission_metadata.json is the submission's; the result is
/autograder/results/results.json. Without one the student sees that the autograder failed, and there
is no score.
"""

from __future__ import annotations

import zipfile
from collections.abc import Collection, Mapping, Sequence
from typing import BinaryIO

from grader.classroom.results.gradescope import results_json
from grader.classroom.results.marks import Task
from grader.classroom.row import StoredResult, StudentRow
from grader.report.page import json_text

EPOCH = (1980, 1, 1, 0, 0, 0)  # the same results make the same bytes
PROGRAM = 0o100755 << 16  # an ordinary file that may be run
SETUP = """#!/usr/bin/env bash
command -v python3 || { apt-get update && apt-get install -y python3; }
"""
RUN = '''#!/usr/bin/env python3
"""Hand out the result that was graded elsewhere."""

import json
import os
import shutil
import sys

root = os.environ.get("AUTOGRADER_ROOT", "/autograder")
with open(os.path.join(root, "submission_metadata.json"), encoding="utf-8") as file:
    number = int(json.load(file)["id"])
result = os.path.join(root, "source", "graded", f"{number}.json")
if not os.path.exists(result):
    sys.exit("This submission was not graded yet, or a person has to look at it first.")
os.makedirs(os.path.join(root, "results"), exist_ok=True)
shutil.copyfile(result, os.path.join(root, "results", "results.json"))
'''


def by_submission(
    results: Sequence[StoredResult],
    tasks: Sequence[Task],
    students: Mapping[str, StudentRow],
    hidden: Collection[str],
) -> dict[int, str]:
    """Return the text of `results.json` for each submission of Gradescope's."""
    groups: dict[int, dict[str, StoredResult]] = {}
    for result in results:
        row = students.get(result.student)
        handed = row.handed.get(result.exercise) if row else None
        number = handed.entry.removeprefix("submission_") if handed else ""
        if handed is not None and handed.system == "gradescope" and number.isdecimal():
            # a group's submission was graded for each of its members: the first counts
            groups.setdefault(int(number), {}).setdefault(result.exercise, result)
    found = {}
    for submission, each in sorted(groups.items()):
        mine = [task for task in tasks if task.slug in each]
        final = results_json([each[task.slug] for task in mine], mine, hidden)
        if final is not None:
            found[submission] = json_text(final)
    return found


def write_autograder(target: BinaryIO, texts: Mapping[int, str]) -> None:
    """Write the zip for Gradescope."""
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        _add(archive, "setup.sh", SETUP, PROGRAM)
        _add(archive, "run_autograder", RUN, PROGRAM)
        for submission, text in texts.items():
            _add(archive, f"graded/{submission}.json", text, 0o100644 << 16)


def _add(archive: zipfile.ZipFile, name: str, text: str, mode: int) -> None:
    info = zipfile.ZipInfo(name, EPOCH)
    info.compress_type = zipfile.ZIP_DEFLATED
    info.external_attr = mode
    archive.writestr(info, text.encode("utf-8", "replace"))
