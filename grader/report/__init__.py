"""Show a grading: in a terminal, and as a page with replays."""
