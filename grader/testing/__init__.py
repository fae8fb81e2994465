"""Students' own tests: pytest's fixture `drive`."""
