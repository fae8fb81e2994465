"""The untrusted side: everything in this package runs in the student's process."""
