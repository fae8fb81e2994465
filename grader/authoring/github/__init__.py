"""What a template repository for GitHub Classroom has besides the students' material."""

import json
from collections.abc import Sequence
from pathlib import Path

from grader.course.exercises import Exercise

REPORT = Path(__file__).with_name("report.py")
WORKFLOW = """\
# GitHub Classroom: every push lets the nodes drive, and reports the points.
name: GitHub Classroom
on: [push, workflow_dispatch]
permissions:
  actions: read
  checks: write
  contents: read
jobs:
  grade:
    if: github.actor != 'github-classroom[bot]'
    runs-on: ubuntu-24.04
    timeout-minutes: 30
    steps:
      - uses: actions/checkout@v4
      - uses: actions/setup-python@v5
        with: {{ python-version: "3.12", cache: pip, cache-dependency-path: constraints.txt }}
      - name: Install the course
        run: python -m pip install --constraint constraints.txt --editable '.[ros,ml]'
{steps}\
      - name: Points
        uses: classroom-resources/autograding-grading-reporter@v1
        env:
{results}\
        with:
          runners: {runners}
"""
STEP = """\
      - name: {title}
        id: {name}
        run: python .github/report.py {slug} >> "$GITHUB_OUTPUT"
"""
IGNORED = ".venv/\n__pycache__/\n*.egg-info/\nreport.html\nrclpy_portable/_ros/\n"


def files(exercises: Sequence[Exercise]) -> dict[str, bytes]:
    """Return the files of the template repository by their paths."""
    return {
        ".github/workflows/classroom.yml": workflow(exercises).encode(),
        ".github/report.py": REPORT.read_bytes(),
        ".gitignore": IGNORED.encode(),
    }


def workflow(exercises: Sequence[Exercise]) -> str:
    """Return the workflow: a step for each exercise, and the reporter."""
    names = [f"exercise-{exercise.number}" for exercise in exercises]
    steps = [
        STEP.format(title=json.dumps(exercise.title), name=name, slug=exercise.slug)
        for name, exercise in zip(names, exercises, strict=True)
    ]
    results = [
        f"          {name.upper()}_RESULTS: ${{{{ steps.{name}.outputs.result }}}}\n"
        for name in names
    ]
    return WORKFLOW.format(steps="".join(steps), results="".join(results), runners=",".join(names))
