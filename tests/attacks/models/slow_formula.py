"""Compute what the model would say instead of asking it.

exercise: slow_model
score: 35
"""

from naive import drive, formula

drive(formula)
