"""No attack: what the naive node is worth.

exercise: slow_model
score: 75
"""

from naive import drive

drive()
