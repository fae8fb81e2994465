"""The grader: runs a student's node in the mock robot and judges what it did."""

import sys

if sys.version_info < (3, 11):  # noqa: UP036  (who has an old one should read this, no traceback)
    sys.exit(
        "course: expected Python 3.11 to 3.14, but this is %d.%d (%s); make an environment with a "  # noqa: UP031
        "newer one: python3.12 -m venv .venv"
        % (sys.version_info[0], sys.version_info[1], sys.executable)
    )
