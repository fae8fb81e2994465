"""Grade a whole class: take in submissions, queue them durably, run them, write the results."""
