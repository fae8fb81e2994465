"""Run an exercise's checks on recordings and add up the points."""
