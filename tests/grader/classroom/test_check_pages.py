"""From the most failed check to those who failed it; a report for each section of the roster."""

from __future__ import annotations

from pathlib import Path

from made_results import OBSTACLES, check, result

from grader.classroom.results.options import ResultOptions
from grader.classroom.results.write import write_results
from grader.classroom.row import StoredResult

HOSTILE = "</style><script>x</script> \u202e"


def wrong(student: str, message: str, *, bags: bool = True) -> StoredResult:
    checks = (
        check("slow_zone", "fail", message=message, actual=HOSTILE, expected="0.15 m/s"),
        check("wiring", "pass"),
        check("blind", "skip"),
    )
    place = Path("recordings") / student if bags else None
    return result(student, *checks, recordings=place)


def test_each_failed_check_has_a_page_that_groups_what_was_said(tmp_path: Path) -> None:
    results = [
        wrong("ada", "0.49 m ahead: too fast"),
        wrong("ben", HOSTILE),
        wrong("chen", "0.31 m ahead: too fast"),
        result("dilara", check("slow_zone", "pass"), check("wiring", "pass")),
    ]
    write_results(results, tmp_path)
    pages = sorted((tmp_path / "checks" / OBSTACLES).iterdir())
    assert [page.name for page in pages] == ["slow_zone.html"]
    text = pages[0].read_text("ascii")
    assert "<script>" not in text
    assert text.index("2 times: ") < text.index("1 time: ")
    assert "3 of 4 failed" in text
    # first one of each kind of failure
    for side, student in (("left", "ada"), ("right", "ben")):
        source = f"../../feedback/{student}/{OBSTACLES}.html#check=slow_zone"
        assert f'src="{source}" title="Replay on the {side}" name="{side}"' in text
    assert 'aria-label="chen on the right"' in text
    assert "frame-src 'self' file:" in text
    assert f'href="checks/{OBSTACLES}/slow_zone.html"' in (tmp_path / "class.html").read_text()

    write_results([results[-1]], tmp_path)
    assert not (tmp_path / "checks").exists()


def test_two_of_one_kind_and_nothing_to_replay(tmp_path: Path) -> None:
    write_results([wrong(name, "too fast") for name in ("ada", "ben")], tmp_path)
    page = tmp_path / "checks" / OBSTACLES / "slow_zone.html"
    assert page.read_text().count("<iframe") == 2
    write_results([wrong("ada", "too fast", bags=False)], tmp_path)
    assert "There are no recordings to replay" in page.read_text()
    assert "<iframe" not in page.read_text()


def test_the_instructor_sees_what_is_hidden_from_students(tmp_path: Path) -> None:
    results = [wrong("ada", "too fast"), result("ben", check("slow_zone", "pass"))]
    write_results(results, tmp_path, ResultOptions(hide="worlds"))
    assert (tmp_path / "replays" / "ada" / f"{OBSTACLES}.html").is_file()
    assert not (tmp_path / "replays" / "ben").exists()
    page = (tmp_path / "checks" / OBSTACLES / "slow_zone.html").read_text()
    assert f"../../replays/ada/{OBSTACLES}.html#check=slow_zone" in page
