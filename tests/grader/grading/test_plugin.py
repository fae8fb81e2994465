"""Checks that are not checks of anything, to see how they are run and what becomes of them."""

import errno
import itertools
import json

import pytest
from plugin_kit import CHAIN, FakeTrials, Run, outcomes

from grader.errors import DiskFull, GraderError, InputError
from grader.trial.trials import TrialFault

# --- the five outcomes ---------------------------------------------------------------------------

FIVE = """
    @check(points=10, scenarios=("a", "b"))
    def test_good(recordings):
        '''It is good.

        This the student does not read.
        '''
        assert recordings == ("a", "b")

    @check(points=20, scenarios=("a",))
    def test_bad(recordings):
        '''It is bad.'''
        fail("drove on", expected="0.00 m/s", actual="0.50 m/s", at=1.25, help="stop")

    @check(points=30, scenarios=("a",), needs=("bad",))
    def test_skipped(recordings):
        '''It hangs on the bad one.'''

    @check(points=5, scenarios=("a",))
    def test_broken(recordings):
        '''It is the grader's own fault.'''
        {}["key"]

    @check(points=7, scenarios=("a",))
    def test_unclear(recordings):
        '''It can not be told.'''
        inconclusive("the machine stalled")
"""


def test_the_five_outcomes(run: Run) -> None:
    grading = run(FIVE)

    assert outcomes(grading) == {
        "good": "pass",
        "bad": "fail",
        "skipped": "skip",
        "broken": "error",
        "unclear": "inconclusive",
    }
    assert (grading.score, grading.max_score) == (10, 60)
    assert grading.faulty
    result = json.loads(json.dumps(grading.as_dict()))
    assert {"exercise", "file", "tier", "score", "max_score", "versions"} <= set(result)
    assert result["provisional"] is True
    assert not grading.full
    assert grading.field_ready is None


def test_what_a_result_says(run: Run) -> None:
    good, bad, skipped, broken, unclear = run(FIVE).checks

    assert (good.title, good.points, good.max_points, good.kind) == ("It is good.", 10, 10, "core")
    assert bad.as_dict() == {
        "id": "bad",
        "title": "It is bad.",
        "kind": "core",
        "points": 0,
        "max_points": 20,
        "outcome": "fail",
        "message": "drove on",
        "expected": "0.00 m/s",
        "actual": "0.50 m/s",
        "time": 1.25,
        "help": "stop",
        "scenario": None,
        "where": "",
        "log": "",
        "asks": "",
        "task": 0,
        "hint": "",
    }
    assert skipped.message == "not judged, because “It is bad.” did not pass"
    assert broken.message == "the grader failed here: KeyError: 'key'"
    assert unclear.message == "the machine stalled"


def test_what_passes_counts_in_full(run: Run) -> None:
    grading = run("""
        @check(points=60, scenarios=("a",))
        def test_one(runs):
            '''One.'''
        @check(points=40, scenarios=("b",), needs=("one",))
        def test_two(runs):
            '''Two.'''
    """)

    assert (grading.score, grading.max_score, grading.full) == (100, 100, True)
    assert not grading.faulty
    assert grading.as_dict()["provisional"] is False


def test_the_order_is_that_of_the_needs(run: Run) -> None:
    grading = run("""
        @check(points=1, scenarios=("a",), needs=("z",))
        def test_a(recordings):
            '''A.'''
        @check(points=1, scenarios=("a",), needs=("b",))
        def test_z(recordings):
            '''Z.'''
        @check(points=1, scenarios=("a",))
        def test_b(recordings):
            '''B.'''
    """)

    assert outcomes(grading) == {"b": "pass", "z": "pass", "a": "pass"}
    assert list(outcomes(grading)) == ["b", "z", "a"]


@pytest.mark.parametrize(
    ("body", "outcome", "rest"),
    [
        ("fail('no')", "fail", "skip"),
        ("inconclusive('no')", "inconclusive", "inconclusive"),
        ("1 / 0", "error", "inconclusive"),
        ("pytest.skip('no')", "error", "inconclusive"),
    ],
)
def test_needs_reach_through(run: Run, body: str, outcome: str, rest: str) -> None:
    grading = run(CHAIN.format(scenario="a", body=body))

    assert outcomes(grading) == {"first": outcome, "second": rest, "third": rest, "alone": "pass"}


@pytest.mark.parametrize(("body", "outcome"), [("fail('no')", "inconclusive"), ("pass", "pass")])
def test_a_stall_of_the_machine_excuses_failures_only(run: Run, body: str, outcome: str) -> None:
    grading = run(CHAIN.format(scenario="late", body=body))

    assert outcomes(grading)["first"] == outcome
    if outcome == "inconclusive":
        assert grading.checks[0].message == "the machine stalled in late: a message was late"


def test_without_a_recording_a_check_is_skipped(run: Run) -> None:
    grading = run(CHAIN.format(scenario="none", body="pass"))

    assert outcomes(grading)["first"] == "skip"
    assert grading.checks[0].message == "no recording of the scenario none"


def test_a_fault_of_the_trials_is_an_error(run: Run) -> None:
    grading = run(FIVE, FakeTrials(GraderError("no host")))

    assert set(outcomes(grading).values()) == {"error", "inconclusive"}
    assert grading.checks[0].message == "the grader failed here: EngineError: no host"
    assert (grading.score, grading.max_score) == (0, 0)


def test_a_fault_in_one_trial_is_an_error_of_the_checks_that_need_it_only(run: Run) -> None:
    fault = TrialFault("a", KeyError("two\nlines"))
    grading = run(CHAIN.format(scenario="a", body="pass"), FakeTrials(fault))

    assert outcomes(grading) == {
        "first": "error", "second": "pass", "third": "pass", "alone": "pass",
    }  # fmt: skip
    assert grading.checks[0].message.startswith("the grader failed in the trial a (KeyError: ")
    assert "\n" not in grading.checks[0].message
    result = grading.as_dict()
    assert (result["score"], result["max_score"], result["provisional"]) == (3, 3, True)
    (note,) = result["notes"]
    assert "trial a (KeyError" in note
    assert note.endswith("The score is provisional.")


def test_a_check_of_two_trials_is_an_error_if_one_of_them_is(run: Run) -> None:
    source = """
        @check(points=1, scenarios=("a", "b"))
        def test_both(recordings):
            '''Both.'''
        @check(points=1, scenarios=("b",))
        def test_one(recordings):
            '''One.'''
            fail("no")
    """
    grading = run(source, FakeTrials(TrialFault("a", ValueError())))

    assert outcomes(grading) == {"both": "error", "one": "fail"}
    assert "(ValueError)" in grading.checks[0].message


def test_a_trial_that_fills_the_disk_ends_the_grading(run: Run) -> None:
    fault = TrialFault("a", OSError())
    fault.__cause__ = OSError(errno.ENOSPC, "No space left on device")
    with pytest.raises(DiskFull, match="trial a"):
        run(CHAIN.format(scenario="a", body="pass"), FakeTrials(fault))


# --- field checks --------------------------------------------------------------------------------

FIELD = """
    @check(field=True, scenarios=("f",))
    def test_field(recordings):
        '''In the field.'''
        {field}
    @check(points=100, scenarios=("c",))
    def test_core(recordings):
        '''At the core.'''
        {core}
"""


@pytest.mark.parametrize(
    ("core", "field", "outcome", "ready"),
    [
        ("pass", "pass", "pass", True),
        ("pass", "fail('no')", "fail", False),
        ("pass", "1 / 0", "error", False),
        ("fail('no')", "pass", "skip", False),
        ("inconclusive('no')", "pass", "skip", False),
        ("1 / 0", "pass", "skip", False),
    ],
)
def test_the_field_comes_after_a_full_core(
    run: Run, core: str, field: str, outcome: str, ready: bool
) -> None:
    trials = FakeTrials()
    grading = run(FIELD.format(core=core, field=field), trials, field=True)

    assert list(outcomes(grading)) == ["core", "field"]
    assert outcomes(grading)["field"] == outcome
    assert grading.field_ready is ready
    assert trials.prepared == ([["c"], ["f"]] if core == "pass" else [["c"]])


def test_the_field_runs_only_if_asked_for_and_alone_if_named(run: Run) -> None:
    trials = FakeTrials()
    assert outcomes(run(FIELD.format(core="pass", field="pass"), trials)) == {"core": "pass"}
    assert trials.prepared == [["c"]]
    alone = run(FIELD.format(core="fail('no')", field="pass"), only=["field"])
    assert outcomes(alone) == {"field": "pass"}


# --- libraries that are not installed ------------------------------------------------------------

DEEP = """
    @check(points=70, scenarios=("a",))
    def test_plain(recordings):
        '''Needs nothing.'''
        {plain}
    @check(points=20, scenarios=("t",), requires=("sklearn", "torch"))
    def test_deep(recordings):
        '''Needs a library.'''
        1 / 0
    @check(points=10, scenarios=("b",), needs=("plain", "deep"))
    def test_deeper(recordings):
        '''Needs a check that needs a library.'''
        1 / 0
    @check(field=True, scenarios=("f",))
    def test_field(recordings):
        '''In the field.'''
    @check(field=True, scenarios=("g",), requires=("torch",))
    def test_deep_field(recordings):
        '''In the field, with a library.'''
"""


def test_what_a_library_is_missing_for_is_neither_won_nor_lost(run: Run) -> None:
    trials = FakeTrials()
    grading = run(DEEP.format(plain="pass"), trials, field=True)

    assert outcomes(grading) == {
        "plain": "pass",
        "deep": "unavailable",
        "deeper": "unavailable",
        "field": "pass",
        "deep_field": "unavailable",
    }
    assert (grading.score, grading.max_score) == (70, 70)
    assert grading.checks[1].message == "PyTorch is not installed here"
    assert (grading.full, grading.field_ready, grading.faulty) == (True, True, False)
    assert trials.asked == ["a", "f"]
    assert "t" not in itertools.chain(*trials.prepared)
    assert "g" not in itertools.chain(*trials.prepared)


def test_a_missing_library_hides_no_failure(run: Run) -> None:
    grading = run(DEEP.format(plain="fail('no')"), field=True)

    assert outcomes(grading) == {
        "plain": "fail",
        "deep": "unavailable",
        "deeper": "skip",
        "field": "skip",
        "deep_field": "unavailable",
    }
    assert (grading.score, grading.max_score) == (0, 80)
    assert not grading.full
    assert grading.field_ready is False


def test_where_the_library_is_the_check_is_judged(run: Run) -> None:
    trials = FakeTrials()
    trials.lacks = lambda scenarios, libraries: ""  # type: ignore[method-assign]
    grading = run(DEEP.format(plain="pass"), trials)

    assert outcomes(grading) == {"plain": "pass", "deep": "error", "deeper": "inconclusive"}
    alone = run(DEEP.format(plain="pass"), only=["deep"])  # and it is missing
    assert (alone.score, alone.max_score, alone.full) == (0, 0, False)


# --- a choice of checks --------------------------------------------------------------------------


def test_only_brings_what_it_needs(run: Run) -> None:
    trials = FakeTrials()
    grading = run(CHAIN.format(scenario="a", body="pass"), trials, only=["third"])

    assert list(outcomes(grading)) == ["first", "second", "third"]
    assert trials.prepared == [["a", "b", "c"]]
    twice = run(CHAIN.format(scenario="a", body="pass"), only=["alone", "alone", "first"])
    assert list(outcomes(twice)) == ["alone", "first"]


def test_an_unknown_check(run: Run) -> None:
    with pytest.raises(InputError, match="unknown check 'thrid'; there are: first, second, third"):
        run(CHAIN.format(scenario="a", body="pass"), only=["thrid"])


# --- a node that dies of one message --------------------------------------------------------------

DIED = """
    @check(points=5, scenarios=("dead",))
    def test_wiring(recordings):
        '''It starts.'''
        fail("it died", where="line 3", title="It survives every message.")

    @check(points=10, scenarios=("dead", "alive"), needs=("wiring",))
    def test_there(recordings):
        '''In the trial in which it died.'''

    @check(points=20, scenarios=("alive",), needs=("wiring",))
    def test_elsewhere(recordings):
        '''In another one.'''

    @check(points=20, scenarios=("alive",), needs=("there",))
    def test_after(recordings):
        '''After one that was not judged.'''
"""


def test_a_node_that_dies_of_a_message_is_judged_where_it_lived_on(run: Run) -> None:
    grading = run(DIED)

    assert outcomes(grading) == {
        "wiring": "fail",
        "there": "skip",
        "elsewhere": "pass",
        "after": "skip",
    }
    assert grading.checks[0].title == "It survives every message."
    assert grading.checks[0].where == "line 3"
    assert grading.score == 20
    assert "It survives every message." in grading.checks[1].message
    not_wired = run(DIED.replace(', title="It survives every message."', ""))
    assert outcomes(not_wired)["elsewhere"] == "skip"
