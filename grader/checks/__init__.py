"""The checks of every exercise: pytest tests that read recordings.

Each exercise has a folder. Its `test_*.py` hold the checks; `contract.py` is the oracle, which says
what is right for what the node was sent; `evidence.py` holds the verdicts that several checks need.
No exercise imports from another's folder (`make lint` asks). What they share lies here:

==================  ============================================================================
verdict             how a check fails, or says that the machine allows no verdict
wiring              whether the node runs and has its topics and services; every check needs it
commands            which Twist answers which scan, and what its fields hold
field               the field suite, which the `test_field.py` of an exercise declares
ahead               the nearest reading ahead of the robot
predictions         what a probe model predicts from a scan: the oracle of the model exercises
model_commands      whether a node commands what its model predicts
driving, moments    how far the robot drove, what it touched, and when to open a failure's replay
turns, reading      which commands belong to which scan; messages that may be anything
==================  ============================================================================
"""
