"""What the checks of all exercises share; each exercise's own lie in `grader/exercises/NAME`.

==================  ============================================================================
verbs               what a check says: wired, follows, every, keeps_distance, …
case, check         a case with its allowed and its given answer; the mark of a check
contract            what an exercise's node is: limits, period, worlds
verdict             how a check fails, or says that the machine allows no verdict; evidence
wiring              whether the node runs and has its topics and services; every check needs it
commands            what a node publishes: which Twist answers which scan, and what it holds
field               the field suite, which the `test_field.py` of an exercise declares
ahead               the nearest reading ahead of the robot
predictions         a node that drives as its model says: the oracle, and what the model was asked
model_commands      the words about such a node
callbacks           how long a callback takes
==================  ============================================================================

A check is a mark, a docstring and a few words; what is right, the oracle `cases` says.
"""
