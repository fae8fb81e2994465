"""The plug-in of pytest at its edges: broken checks, long messages, other people's settings."""

import os
from pathlib import Path

import pytest
from plugin_kit import CHAIN, Run, outcomes

from grader.errors import GraderError
from grader.grading.plugin import MAX_MESSAGE

# --- checks that are none ------------------------------------------------------------------------

BROKEN = {
    "no mark": ("def test_x(recordings):\n    '''X.'''", "test_x has no check mark"),
    "no docstring": (
        "@check(points=1, scenarios=())\ndef test_x(recordings): pass",
        "test_x has no docstring",
    ),
    "an empty docstring": (
        "@check(points=1, scenarios=())\ndef test_x(recordings):\n    '''  '''",
        "test_x has no docstring",
    ),
    "no scenarios": (
        "@check(points=1)\ndef test_x(recordings):\n    '''X.'''",
        "names no scenarios",
    ),
    "an unknown need": (
        "@check(points=1, scenarios=(), needs=('y',))\ndef test_x(recordings):\n    '''X.'''",
        "a check needs 'y', which does not exist",
    ),
    "needs in a circle": (
        "@check(points=1, scenarios=(), needs=('x',))\ndef test_x(recordings):\n    '''X.'''",
        "needs itself",
    ),
    "two of one name": (
        "@check(points=1, scenarios=())\nclass TestA:\n    def test_x(self):\n        '''X.'''\n"
        "@check(points=1, scenarios=())\ndef test_x():\n    '''X.'''",
        "two checks of one exercise have the same name",
    ),
    "no checks": ("", "can't be run"),
    "a module that can't be imported": ("import no_such_module", "can't be run"),
    "a syntax error": ("def test_x(:", "can't be run"),
}


@pytest.mark.parametrize("what", BROKEN)
def test_broken_checks_are_the_graders_fault(run: Run, what: str) -> None:
    source, message = BROKEN[what]
    with pytest.raises(GraderError) as caught:
        run(source)

    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


# --- what checks may do --------------------------------------------------------------------------

DOES = """
    @check(points=1, scenarios=("a",))
    def test_does(recordings):
        '''Does something.'''
        {}
    @check(points=1, scenarios=("a",))
    def test_next(recordings):
        '''Comes next.'''
"""


def test_long_messages_are_cut(run: Run) -> None:
    grading = run(DOES.format("fail('x' * 10**6, expected='y' * 10**6, actual='z', help='h')"))
    check = grading.checks[0]

    assert (len(check.message), len(check.expected)) == (MAX_MESSAGE, MAX_MESSAGE)
    assert (check.actual, check.help) == ("z", "h")
    broken = run(DOES.format("raise ValueError('x' * 10**6)")).checks[0]
    assert len(broken.message) == MAX_MESSAGE


@pytest.mark.parametrize(
    "does",
    [
        "raise SystemExit(3)",
        "sys.exit()",
        "raise BaseException('odd')",
        "raise GeneratorExit",
        "pytest.fail('no')",
        "pytest.xfail('no')",
        "assert 1 == 2",
        "raise RecursionError",
        "os.chdir('/nonexistent')",
        "def f(): f()\n        f()",
    ],
)
def test_whatever_else_a_check_raises_is_an_error(run: Run, does: str) -> None:
    grading = run(DOES.format(does))

    assert outcomes(grading) == {"does": "error", "next": "pass"}
    assert grading.max_score == 1


def test_an_interrupt_is_an_interrupt(run: Run) -> None:
    with pytest.raises(KeyboardInterrupt):
        run(DOES.format("raise KeyboardInterrupt"))


@pytest.mark.parametrize("does", ["print('x' * 1000)", "import warnings; warnings.warn('old')"])
def test_checks_may_print_and_warn(run: Run, capfd: pytest.CaptureFixture[str], does: str) -> None:
    assert outcomes(run(DOES.format(does)))["does"] == "pass"
    assert capfd.readouterr() == ("", "")


# --- the outside ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("PYTEST_ADDOPTS", "-k nothing --maxfail=1 -p no:python"),
        ("PYTEST_ADDOPTS", "--no-such-option"),
        ("PYTEST_PLUGINS", "no_such_plugin"),
    ],
)
def test_settings_of_other_runs_do_not_disturb(
    run: Run, monkeypatch: pytest.MonkeyPatch, name: str, value: str
) -> None:
    monkeypatch.setenv(name, value)
    grading = run(CHAIN.format(scenario="a", body="pass"))

    assert set(outcomes(grading).values()) == {"pass"}
    assert os.environ[name] == value


def test_configurations_nearby_do_not_disturb(run: Run, tmp_path: Path) -> None:
    (tmp_path / "pytest.ini").write_text("[pytest]\naddopts = --no-such-option\n")
    (tmp_path / "pyproject.toml").write_text("[tool.pytest.ini_options]\naddopts = '-k nothing'\n")

    assert outcomes(run(DOES.format("pass")))["does"] == "pass"
