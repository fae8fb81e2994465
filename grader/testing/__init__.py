"""Students' own tests: pytest's fixtures `drive` and `virtual_time`."""
