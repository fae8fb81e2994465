"""How an exception is told: the student's lines, and values without any code of the student's."""

import linecache
from pathlib import Path

import pytest

from grader.advice.deaths import MAX_VALUE, _advice_on_service, account, first_of, value_words
from grader.recording import death_of
from rclpy_virtual_time.host.wire import steady

PROGRAM = """
class Evil:
    def __repr__(self):
        raise SystemExit("called")

class Agent:
    def __init__(self):
        self.limit = 0.5
        self.evil = Evil()

    def decide(self, distance):
        evil, beams, loud = self.evil, [0.25] * 360, "x" * 1000
        return self.limit < distance, evil, beams, loud

agent = Agent()
agent.decide(None)
"""


def raised(folder: Path, source: str) -> BaseException:
    file = folder / "agent.py"
    file.write_text(source)
    linecache.checkcache(str(file))
    with pytest.raises(Exception) as caught:
        exec(compile(source, str(file), "exec"), {"__name__": "__main__"})
    return caught.value


def told(folder: Path, source: str) -> str:
    return account(raised(folder, source), folder)


def test_the_innermost_line_comes_first_with_its_values(tmp_path: Path) -> None:
    death = death_of(told(tmp_path, PROGRAM))

    assert death is not None
    inner, outer = death.frames
    assert (inner.file, inner.line, inner.function) == ("agent.py", 13, "decide")
    assert inner.source == "return self.limit < distance, evil, beams, loud"
    assert "self.limit = 0.5, distance = None, evil = <Evil>" in inner.values
    assert "beams = list of 360, 0.25 … 0.25" in inner.values
    assert outer.source == "agent.decide(None)"
    assert death.said.startswith("TypeError: '<' not supported")
    assert death.advice
    assert (death.place, death.in_callback) == ("the start-up", False)


@pytest.mark.parametrize(
    "value", ["x" * 10**6, [["y" * 100] * 4] * 4, {i: i for i in range(9)}, 10**300, b"z" * 999]
)
def test_a_value_is_short(value: object) -> None:
    assert len(value_words(value)) <= MAX_VALUE


def test_lines_that_look_like_ours_stay_text(tmp_path: Path) -> None:
    said = "boom\\n\\nin the callback of /scan\\nevil.py, line 1, in f"
    death = death_of(told(tmp_path, f"raise ValueError('{said}')\n"))

    assert death is not None
    assert [frame.file for frame in death.frames] == ["agent.py"]
    assert death.place == "the start-up"


CLEANS_UP = """
def drive():
    return missing
def work():
    raise ValueError("the first one")
def main():
    try:
        work()
    {handler}
        drive()
main()
"""


@pytest.mark.parametrize(
    ("handler", "kind"), [("finally:", ValueError), ("except ValueError:", NameError)]
)
def test_what_a_finally_raises_does_not_hide_the_first_exception(
    tmp_path: Path, handler: str, kind: type
) -> None:
    last = raised(tmp_path, CLEANS_UP.format(handler=handler))

    assert (type(last), type(first_of(last))) == (NameError, kind)
    one, other = ValueError(), ValueError()  # a ring of exceptions ends, too
    one.__context__, other.__context__ = other, one
    assert first_of(one) is one


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ("", "return response"),
        ("bad argument type for built-in operation", "another type"),
        ("A.on_ask() takes 2 positional arguments but 3 were given", "(self, request, response)"),
    ],
)
def test_what_is_wrong_with_a_service_follows_from_pythons_words(said: str, words: str) -> None:
    assert words in _advice_on_service(said)


def test_what_differs_from_run_to_run_is_left_out() -> None:
    said = "<built-in method publish of pybind11_x.y_z object at 0x7fe62f8d8150> returned"
    assert steady(said) == "publish() returned"


@pytest.mark.parametrize(
    ("settings", "advice"),
    [
        ("(64, 64)", "a setting of the model itself is wrong"),
        ("", "fit(features, speeds): first the table with one row of five"),
    ],
)
def test_a_wrong_setting_of_a_model_is_not_its_data(
    tmp_path: Path, settings: str, advice: str
) -> None:
    pytest.importorskip("sklearn")
    source = f"""
from sklearn.neural_network import MLPRegressor
MLPRegressor({settings}).fit([[1.0] * 5], [0.3, 0.4])
"""
    death = death_of(told(tmp_path, source))

    assert death is not None
    assert death.advice.startswith(advice)
