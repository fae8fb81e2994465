"""What the checks of all exercises share; each exercise's own lie in `grader/exercises/NAME`.

==================  ============================================================================
words               the words of a check: wired, follows, every, keeps_distance, …
case, check         an occasion with what is allowed and what was said; the mark of a check
contract            what an exercise's node is: limits, period, worlds
verdict             how a check fails, or says that the machine allows no verdict
wiring              whether the node runs and has its topics and services; every check needs it
commands            which Twist answers which scan, and what its fields hold
field               the field suite, which the `test_field.py` of an exercise declares
ahead               the nearest reading ahead of the robot
predictions         what a probe model predicts from a scan; model_cases: the occasions of a node
                    that drives as its model says; model_commands: their words
inferences          what the judge's own models were asked
callbacks           how long a callback takes
moments             when to open the replay of a failure that is about a whole run
turns, reading      which commands belong to which scan; messages that may be anything
evidence            what an exercise's `causes.py` returns
==================  ============================================================================

A check is a mark, a docstring and a few words; what is right stands in the exercise's one oracle,
`cases` in its `contract.py`. No exercise imports from another's folder (`make lint` asks).
"""
