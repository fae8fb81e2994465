"""Reading and merging TOML; the errors of `convert` are in test_scenario_errors.py."""

import copy

from hypothesis import given, settings
from hypothesis import strategies as st
from simulated import refusal

from sim.toml_input import merged, nearest, parse_toml, shown

SETTINGS = settings(derandomize=True, deadline=None, max_examples=60)
keys = st.sampled_from("abc")
values = st.integers() | st.lists(st.integers(), max_size=2)
tables = st.recursive(
    st.dictionaries(keys, values, max_size=3),
    lambda inner: st.dictionaries(keys, values | inner, max_size=3),
    max_leaves=6,
)


@SETTINGS
@given(tables, tables)
def test_merging_changes_neither_table_and_is_idempotent(base, own):
    before = copy.deepcopy((base, own))
    result = merged(base, own)
    assert (base, own) == before
    assert merged(result, own) == result
    assert merged(base, {}) == merged({}, base) == base
    assert result.keys() == base.keys() | own.keys()


def test_the_nearest_name_is_suggested_or_all_are_listed():
    assert nearest("hal", ["hall", "store"]) == "; did you mean 'hall'?"
    assert nearest("x", ["store", "hall"]) == "; there is: hall, store"
    assert nearest("x", []) == ""


def test_what_is_not_toml_is_said_in_one_line():
    said = refusal(parse_toml, "a = \n", "my\nfile.toml")
    assert said.startswith("my file.toml: not valid TOML: ")


def test_a_long_value_is_shortened():
    assert shown([1, "a", True]) == '[1, "a", true]'
    assert shown(float("nan")) == "nan"
    assert shown("x" * 100) == '"' + "x" * 58 + "…"
