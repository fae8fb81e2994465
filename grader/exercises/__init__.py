"""The judge's side of each exercise: its contract, its checks and its scenarios."""
