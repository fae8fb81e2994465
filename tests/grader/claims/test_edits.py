"""Edits fit in exactly one place, or say why not."""

import pytest

from grader.claims.edits import EditError, edited

LINES = ["def f(x):", "    if x:", "        return 1", "", "    return 0", "    return 0"]


def test_lines_go_come_and_stay() -> None:
    edit = "-    if x:\n+    if not x:\n+        print(x)\n         return 1\n"
    expected = ["def f(x):", "    if not x:", "        print(x)", *LINES[2:]]
    assert edited(LINES, edit, "f.py") == expected


def test_hunks_may_come_in_any_order_and_at_the_ends() -> None:
    edit = "     return 0\n-    return 0\n@@\n+import os\n def f(x):\n"
    assert edited(LINES, edit, "f.py") == ["import os", *LINES[:5]]


def test_an_empty_line_stays_though_its_space_is_lost() -> None:
    edit = "         return 1\n\n-    return 0\n+    return 2\n"
    assert edited(LINES, edit, "f.py") == [*LINES[:4], "    return 2", "    return 0"]


def test_a_line_that_looks_like_a_separator_is_none() -> None:
    assert edited(["@@", "x"], " @@\n-x\n+y\n", "f.py") == ["@@", "y"]


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (
            "-    return 0\n+    return 2\n",
            "hunk '-    return 0' fits 2 times in f.py, expected once; "
            "add a line beside it, to tell the places apart",
        ),
        (
            "-    if  x:\n+    if not x:\n",
            "hunk '-    if  x:' fits 0 times in f.py, expected once; "
            "the line nearest to '    if  x:' is '    if x:'",
        ),
        (
            " def f(x):\n     if x:\n-    return 0\n",
            "hunk ' def f(x):' fits 0 times in f.py, expected once; "
            "its lines are there, but behind '    if x:' stands '        return 1'",
        ),
        ("     return 0\n-    if x:\n", "but behind '    return 0' stands nothing"),
        ("-    if x\n+    if y\n", "the line nearest to '    if x' is '    if x:'"),
        ("     if x:\n", "hunk '     if x:' changes nothing"),
        ("-    if x:\n+    if x:\n", "hunk '-    if x:' changes nothing"),
        ("+import os\n", "hunk '+import os' has no old line, so nobody knows where it belongs"),
        ("", "hunk '' has no old line, so nobody knows where it belongs"),
        ("-    if x:\n@@\n", "hunk '' has no old line"),
        ("x = 1\n", "line 'x = 1' begins with none of '-', '+' and ' '"),
        (
            "-def f(x):\n     if x:\n@@\n     if x:\n+        pass\n",
            "hunk '     if x:' overlaps another",
        ),
    ],
)
def test_what_does_not_fit_is_an_error(edit: str, message: str) -> None:
    with pytest.raises(EditError) as caught:
        edited(LINES, edit, "f.py")
    assert message in str(caught.value)
