"""The grader: runs a student's node in the mock robot and judges what it did."""
