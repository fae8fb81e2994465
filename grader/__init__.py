"""The grader: runs a student's node in the mock robot and judges what it did.

PYTEST_DONT_REWRITE: the plug-in `grader.testing.plugin` makes pytest look at this package.
"""
