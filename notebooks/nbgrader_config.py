"""nbgrader for this course: `cd notebooks`, then any nbgrader command.

What is graded are nodes, driven and judged by the course's own judge: no cell of a student runs.
"""

from grader.nbgrader import configure

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
