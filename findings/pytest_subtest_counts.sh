#!/usr/bin/env bash
# Guess: a test in which a subtest fails is one failed test, whether it is unittest's subTest or
#        pytest's fixture `subtests`; a JUnit file has a testcase for each of `tests`, with one
#        failure at most.
# Seen:  a unittest method whose subtests fail is counted as passed, too, beside a failure for each
#        of them; one with the fixture is failed, and counted once more. In the JUnit file there is
#        one testcase for each test, with several <failure> in it, while `tests` and `failures`
#        count the subtests: who counts points by either gets other points than by testcases. The
#        exit status is 1 in both cases.
# With:  pytest 9.2.0 (Python 3.11), 2026-11-29
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install pytest==9.2.0
cd "$work"
cat > test_robot.py <<'PY'
import unittest


class Robot(unittest.TestCase):
    def test_speeds(self):
        for speed in range(4):
            with self.subTest(speed=speed):
                assert speed % 2

    def test_sound(self):
        for speed in range(4):
            with self.subTest(speed=speed):
                pass


def test_turns(subtests):
    for turn in range(4):
        with subtests.test(turn=turn):
            assert turn % 2
PY
for which in test_speeds test_turns test_sound; do
  echo "$which"
  venv/bin/pytest -q -p no:cacheprovider -k "$which" --junitxml=j.xml > out || echo "  exit $?"
  tail -1 out | sed 's/^/  /; s/ in [0-9.]*s//'
  venv/bin/python - <<'PY'
from xml.etree import ElementTree

suite = ElementTree.parse("j.xml").getroot()[0]
print("  junit: tests", suite.get("tests"), "failures", suite.get("failures"), end="; ")
print("testcases", [[child.tag for child in case] for case in suite])
PY
done > seen
diff "$work/seen" - <<'SEEN' && echo "as it was"
test_speeds
  exit 1
  2 failed, 1 passed, 2 deselected, 2 subtests passed
  junit: tests 5 failures 2; testcases [['failure', 'failure']]
test_turns
  exit 1
  3 failed, 2 deselected, 2 subtests passed
  junit: tests 5 failures 3; testcases [['failure', 'failure', 'failure']]
test_sound
  1 passed, 2 deselected, 4 subtests passed
  junit: tests 5 failures 0; testcases [[]]
SEEN
