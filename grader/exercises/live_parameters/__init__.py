"""The judge of exercise 10, Live parameters."""
