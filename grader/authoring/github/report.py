"""Grade one exercise of this repository; give the result to GitHub Classroom's reporter.

    python .github/report.py EXERCISE >> "$GITHUB_OUTPUT"

Your file may lie at the top of the repository, or in the exercise's own folder. The result is what
classroom-resources/autograding-grading-reporter reads. It is feedback: who can push here can change
this file, too, so your instructor grades the repository again, elsewhere.
"""

import base64
import json
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path
from typing import Any

STATUS = {"pass": "pass", "fail": "fail", "skip": "fail"}  # all else: could not be judged
ABOUT = "exercise.toml"


def main(arguments: list[str]) -> int:
    """Print the line for GITHUB_OUTPUT; the table goes to the log."""
    folder = Path("exercises", arguments[0])
    about = tomllib.loads((folder / ABOUT).read_text("utf-8"))
    first = about["files"][0]
    where = Path(first) if Path(first).is_file() else folder / first
    with tempfile.TemporaryDirectory() as name:
        result = Path(name, "result.json")
        command = [sys.executable, "-m", "grader.cli", "grade", arguments[0], str(where)]
        done = subprocess.run([*command, "--json", str(result)], stdout=sys.stderr, check=False)
        if not result.is_file():
            return done.returncode or 1
        grading = json.loads(result.read_text("utf-8"))
    text = json.dumps(as_reported(grading))
    print(f"result={base64.b64encode(text.encode()).decode()}")
    return 0


def as_reported(grading: dict[str, Any]) -> dict[str, Any]:
    """Return a grading as GitHub Classroom's reporter reads it.

    It adds up the tests' points, so those of a capped score are scaled.
    """
    core = [check for check in grading["checks"] if check["kind"] == "core"]
    share = grading["score"] / grading["raw_score"] if grading.get("raw_score") else 1.0
    tests = [
        {
            "name": check["title"],
            "status": STATUS.get(check["outcome"], "error"),
            "score": round(check["points"] * share, 2),
            "message": check.get("message") or grading.get("cap") or "",
            "test_code": "",
            "filename": "",
            "line_no": 0,
            "duration": 0,
        }
        for check in core
    ]
    words = {test["status"] for test in tests}
    status = "error" if "error" in words else "fail" if "fail" in words else "pass"
    most = sum(check["max_points"] for check in core)
    return {"version": 1, "status": status, "max_score": most, "tests": tests}


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
