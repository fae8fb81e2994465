"""The plug-in reads cells without running them."""

import pytest

from grader.errors import InputError
from grader.nbgrader.cells import Wanted, definition, last_definitions, made_files, wanted

NODE = "x = 1\n"


@pytest.mark.parametrize(
    "source",
    [
        "%%node agent.py\nx = 1", "%%node  agent.py \nx = 1", "%%node\tagent.py\t\nx = 1",
        "\n\n  \n%%node agent.py\nx = 1", "%%node agent.py\r\nx = 1\r\n",
        "\ufeff%%node agent.py\nx = 1", "# my solution\n\n# really\n%%node agent.py\nx = 1",
        "%%time\n%%node agent.py\nx = 1", "    %%node agent.py\n    x = 1",
        '%%node "agent.py"\nx = 1', "%%writefile agent.py\nx = 1", "%%file ./agent.py\nx = 1",
        "%%time\n%%writefile '/content/agent.py'\nx = 1",
    ],
)  # fmt: skip
def test_oddly_spelled_magics_are_understood(source: str) -> None:
    made = definition(source)
    assert made is not None
    assert (made.file, made.text) == ("agent.py", NODE)


@pytest.mark.parametrize(
    "source",
    [
        "x = 1\n%%node agent.py\nx = 1", "%%nodes agent.py\nx = 1", "%%node",
        "%node agent.py\nx = 1", "'''\n%%node agent.py\n'''", "# %%node agent.py\nx = 1",
    ],
)  # fmt: skip
def test_other_cells_make_no_file(source: str) -> None:
    assert definition(source) is None


def test_a_line_of_a_string_that_looks_like_a_magic_stays() -> None:
    made = definition("%%node agent.py\ns = '''\n%%node other.py\n'''\n")
    assert made is not None
    assert made.text == "s = '''\n%%node other.py\n'''\n"


def test_the_last_definition_counts_and_the_student_is_told() -> None:
    cells = [
        ("code", "%%node agent.py\nfirst"),
        ("code", "%%node other.py\n?"),
        ("code", "%%node agent.py\nlast"),
        ("markdown", "%%node agent.py\nno code"),
    ]
    texts, remarks = last_definitions(cells, ["agent.py"])
    assert texts == {"agent.py": "last\n"}
    assert remarks == ["2 cells write agent.py; the last, cell 3, counts."]


@pytest.mark.parametrize(
    ("cells", "found", "said"),
    [
        ([("code", "%%node agent.py\nx")] * 2, {"agent.py": "x\n"}, []),
        (
            [("markdown", "%%node agent.py\nx")],
            {"agent.py": "x\n"},
            ["Cell 1 writes agent.py but is no code cell; it was used as one."],
        ),
        *(
            ([("code", f"%%node {name}\nx")], {}, [])
            for name in ("../agent.py", "/agent.py", "A.py")
        ),
    ],
)
def test_copies_retyped_cells_and_other_names(
    cells: list[tuple[str, str]], found: dict[str, str], said: list[str]
) -> None:
    assert last_definitions(cells, ["agent.py"]) == (found, said)


def test_a_cell_may_go_on_where_another_ended() -> None:
    said = ("-a agent.py", "agent.py", "--append agent.py", "agent.py -a")
    cells = [("code", f"%%writefile {words}\n{words}") for words in said]
    texts, remarks = last_definitions(cells, ["agent.py"])
    assert texts == {"agent.py": "agent.py\n--append agent.py\nagent.py -a\n"}
    assert remarks == ["2 cells write agent.py; the last, cell 4, counts."]


def test_a_test_cell_names_its_checks() -> None:
    assert wanted('check("1:wiring, slow_zone")') == Wanted(
        "obstacle_avoidance", ("wiring", "slow_zone")
    )
    assert wanted("check('goal_seeking')") == Wanted("goal_seeking", ())
    others = ("assert True", 'check("1")\nprint()', 'check("1", field=True)', "check(name)", "no (")
    assert [wanted(source) for source in others] == [None] * len(others)


def test_an_unknown_exercise_is_refused() -> None:
    with pytest.raises(InputError, match="did you mean goal_seeking"):
        wanted('check("goal_seekin")')


def test_made_files_are_few_and_short() -> None:
    cells = [("code", f"%%node {'x' * 900}{n}.py\n") for n in range(9)]
    assert [len(name) for name in made_files(cells)] == [60]
