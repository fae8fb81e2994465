"""nbgrader for this course: `cd notebooks`, then any nbgrader command.

What is graded are nodes, driven and judged by the course's own judge: no cell of a student runs.
"""

import sys
from pathlib import Path

from grader.nbgrader import configure

source = Path(__file__).with_name("source")
parts = "notebooks/text/*/*.md", "exercises/*/*.md", "solutions/*/*.py", "lessons/quiz.md"
made_from = [path.stat().st_mtime for part in parts for path in source.parents[1].glob(part)]
make = (
    "`make assignments` in the course's folder writes them, and so does "
    "`python -m grader.notebook.build` in an environment of your own."
)
if not any(source.glob("*/*.ipynb")):
    sys.exit(f"{source}: expected the course's notebooks, but they are not made yet. {make}")
if source.stat().st_mtime < max(made_from, default=0.0):
    print(f"{source}: older than what it is made from. {make}", file=sys.stderr)

c = get_config()  # noqa: F821  (nbgrader's)
c.CourseDirectory.course_id = "rclpy_agents"
configure(c)

# Behind isolation that is too weak nothing is graded (`course doctor` tells). On a throw-away
# machine that has nothing worth stealing:
# c.JudgeNodes.trust = True

# What late work costs, in per cent of its points for each day begun; nothing unless you say so.
# c.LatePenalty.per_day = 10
# c.LatePenalty.grace_minutes = 60
# c.LatePenalty.at_most = 50

# Worlds of each student's own, as with `course autograde --secret`:
# c.JudgeNodes.secret = "/a/folder/of/your/own/course.secret"
