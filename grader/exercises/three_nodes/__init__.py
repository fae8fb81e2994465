"""The judge of exercise 11, Launch files."""
