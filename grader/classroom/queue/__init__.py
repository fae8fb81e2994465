"""The queue of a class: what waits is graded on workers, and known solutions watch the grader."""
