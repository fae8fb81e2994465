"""Run an exercise's checks over recordings and add up the points."""
