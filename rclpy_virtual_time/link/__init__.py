"""The judge's end of the pipe, and the hosts behind it."""
