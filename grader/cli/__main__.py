"""`python -m grader.cli` is the command `course`."""

from grader.cli import main

main()
