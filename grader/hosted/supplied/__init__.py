"""Models and programs of ours that run beside a student's node."""
