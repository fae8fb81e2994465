"""What an exercise is: its description, files, seeds and skeletons, and how students hand in."""
