"""The fixture `virtual_time` of pytest."""
