"""course release, in a process of its own."""

from pathlib import Path

import pytest
from command_line import course

from grader.cli.release import release
from grader.course import exercises
from grader.errors import InputError

# What is made for a release is tested with the whole of it: tests/notebooks/test_handouts.py.


def test_the_command_releases_one_exercise(tmp_path: Path) -> None:
    week = tmp_path / "week"
    done = course("release", week, "--exercise", "3", "--student-package", "--plain")
    assert (done.code, done.err) == (0, "")
    assert done.out == f"Students' material: {week}\nThe same, packed: {week}.zip\n"
    assert (week / "exercises" / "goal_seeking").is_dir()


@pytest.mark.long
def test_the_command_says_which_skeletons_give_something_away(tmp_path: Path) -> None:
    done = course("release", tmp_path / "all", "--plain")
    assert done.code == 0
    said = "Note: obstacle_avoidance's solution is partly in "
    assert [line.startswith(said) for line in done.err.splitlines()] == [True]
    assert "trend_agent.py" in done.err


def test_what_a_release_lacks_is_said_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def handouts(*_: object, **__: object) -> None:
        raise InputError(capsys.readouterr().err)

    monkeypatch.setattr("grader.authoring.handouts.handouts", handouts)
    monkeypatch.setattr("grader.authoring.carried.built_wheel", lambda: None)
    said = r"(?s)no wheel is in dist, .*run `make wheel` first.*takes a minute or two"
    with pytest.raises(InputError, match=said):
        release.main([str(tmp_path / "week")], standalone_mode=False)


def test_what_is_no_checkout_is_no_place_for_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(exercises, "ROOT", tmp_path)
    with pytest.raises(InputError, match="expected a checkout of the course, with solutions/"):
        release.main([str(tmp_path / "week")], standalone_mode=False)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ("--plain --no-answers", "--no-answers is for the site, which --plain leaves out"),
        ("--plain --ways", "--ways is for the site, which --plain leaves out"),
        ("--gradescope --plain", "--gradescope writes nothing for students"),
        ("--hide worlds", "--secret, --field and --hide go with --gradescope"),
        ("--gradescope --hide world", r"did you mean worlds\?"),
        ("--gradescope --secret nowhere", "nowhere"),
    ],
)
def test_wrong_usage_is_told(options: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=said):
        release.main([str(tmp_path / "week"), *options.split()], standalone_mode=False)
    assert not (tmp_path / "week").exists()
