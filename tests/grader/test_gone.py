"""What went is answered with a sentence that says what replaces it."""

import pytest

from grader.cli import cli, run
from grader.cli.gone import GONE


@pytest.mark.parametrize(("command", "option"), GONE)
def test_what_went_is_answered_with_what_replaces_it(command, option, capsys):
    words = ["my_agent.py", f"{option}=3"] if option else ["my_agent.py"]
    assert run([command, *words]) == 2
    assert " ".join(capsys.readouterr().err.split()) == f"course: {GONE[command, option]}"


def test_nothing_that_is_there_is_called_gone():
    for command, option in GONE:
        there = cli.commands.get(command)
        assert not there or option not in {name for each in there.params for name in each.opts}
