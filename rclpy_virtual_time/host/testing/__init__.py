"""A test of pytest's that runs in virtual time: its session, and what it may do to time."""
