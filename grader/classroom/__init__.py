"""Grade a whole class: take in submissions, keep a queue that survives, run it, store results."""
