"""Mutants made by machine: right nodes with one edit, or with something around them."""
