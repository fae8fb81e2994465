"""The lesson's numbers are the contract's: each has a law, and no page writes one by hand."""

import ast
import importlib
import math
import operator
import re
import tomllib
from pathlib import Path
from typing import Any

from contract import Number, read
from lesson_pages import LESSONS, PAGES, ROOT, blocks, prose

NUMBERS = read()
FIGURES = tuple(sorted((LESSONS / "figures").glob("*.svg")))
ROLE = re.compile(r"\{contract\}`([^`]+)`")
UNIT = re.compile(
    r"(?<![\w.])[-±]?\d[\d.,]*(?:e\d+)?[\s\u00a0-]?"
    r"(?:m/s²|m/s|rad/s|milliseconds?|seconds?|met(?:er|re)s?|ms|Hz|cm|mm|km|[ms]\b|°|%)"
)
# What pages may write by hand, and why: numbers of no contract.
BY_HAND = {
    "120 cm": "frames: an example of a distance",
    "0.001 ms": "real_time: what perf_counter says of computing in virtual time",
    "1.5 m": "loop: the listing's own threshold",
    "0.3 m/s": "parameters: the listing's own speed",
    "45 seconds": "index: how its minutes are counted",
    "20 ms": "why: what people say of their model, an example",
    "0.4 m": "state: 2 s at the odometer's own speed",
    "170°": "state: an example of an angle",
    "-170°": "state: an example of an angle",
    "-340°": "state: an example of an angle",
    "20°": "state: an example of an angle",
    "1 m/s": "state: the closing speed of the example's four readings",
}
# Numbers that stand in programs, as the contract has them.
IN_PROGRAMS = {
    "beat": (
        ("time.sleep({:g})", "model_time", 1e-3),
        ("create_timer({:g}, self.control)", "control_period", 1e-3),
    ),
    "stale": (('"takes", {:g}', "model_time", 1e-3), ('"depth", {:g}', "queue_depth", 1)),
    "adjustable": (("<= parameter.value <= {:g}", "robot_speed", 1),),
    "loop": (
        ("beam_ahead(-math.pi, math.tau / {:g})", "lidar_beams", 1),
        ("beam_ahead(0.0, math.tau / {:g})", "lds_beams", 1),
        ("math.radians(-{:g})", "wide_half", 1),
    ),
    "node": (("usable(reading, {:g}, ", "lidar_min", 1), (", {:.1f}))", "lidar_max", 1)),
    "models": (
        ("np.minimum({:g}, ", "model_speed", 1),
        ("np.sqrt(2 * {:g} * ", "robot_acceleration", 1),
        ("(distance - {:g})", "expert_margin", 1),
        (", {:.1f}):", "lidar_max", 1),
    ),
    "state": (("np.arange({:g}) * 0.1", "memory", 1),),
}  # fmt: skip
ARITHMETIC = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
}  # fmt: skip


# --- laws ----------------------------------------------------------------------------------


def value_of(law: str) -> float:
    """Return what the course says: `= expression`, `FILE:KEY` or `MODULE:NAME`."""
    if law.startswith("="):
        return evaluate(ast.parse(law[1:].strip(), mode="eval").body)
    place, name = law.split(":", 1)
    if place.endswith(".toml"):
        return float(in_toml(tomllib.loads((ROOT / place).read_text("utf-8")), name))
    if place.endswith(".py"):
        return constant(ROOT / place, name)
    found: Any = importlib.import_module(place)
    for part in name.split("."):
        if part.endswith("()"):
            found = getattr(found, part[:-2])()
        else:
            found = found[part] if isinstance(found, dict) else getattr(found, part)
    return float(found)


def evaluate(node: ast.expr) -> float:
    """Return the value of an expression over other numbers."""
    match node:
        case ast.BinOp(left, op, right):
            return float(ARITHMETIC[type(op)](evaluate(left), evaluate(right)))
        case ast.Name(name):
            return NUMBERS[name].value
        case ast.Constant(value) if isinstance(value, int | float):
            return value
    raise ValueError(ast.dump(node))


def in_toml(table: Any, key: str) -> Any:
    """Return a value by its dotted key, a number in lists; names of tables may have dots."""
    if not key:
        return table
    if isinstance(table, list):
        place, _, rest = key.partition(".")
        return in_toml(table[int(place)], rest)
    for name in sorted(table, key=len, reverse=True):
        if key == name or key.startswith(name + "."):
            return in_toml(table[name], key[len(name) + 1 :])
    raise KeyError(key)


def constant(file: Path, name: str) -> float:
    """Return a module's constant without importing it."""
    for node in ast.parse(file.read_text("utf-8")).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == name:
            return float(ast.literal_eval(node.value))
    raise KeyError(name)


def agrees(number: Number, law: float) -> bool:
    return math.isclose(number.value, number.scale * law, rel_tol=1e-9, abs_tol=number.about)


def test_numbers_are_what_the_course_says() -> None:
    faults = []
    for key, number in NUMBERS.items():
        if bool(number.law) == bool(number.own):
            faults.append(f"{key}: expected either a law or a reason")
        elif number.law:
            law = value_of(number.law)
            if not agrees(number, law):
                faults.append(f"{key}: {number.law} is {law}, and not {number.value}")
            if agrees(number, 1.1 * law):
                faults.append(f"{key}: would not notice a changed contract")
    assert faults == []


# --- pages ---------------------------------------------------------------------------------


def test_every_number_is_shown_and_every_shown_number_exists() -> None:
    shown = {key for page in PAGES for key in ROLE.findall(page.read_text("utf-8"))}
    assert shown <= set(NUMBERS)
    drawn = " ".join(map(words_of, FIGURES))
    derived = " ".join(n.law for n in NUMBERS.values() if n.law.startswith("="))
    used = shown | {key for key, number in NUMBERS.items() if number.text in drawn}
    used |= set(re.findall(r"\w+", derived))
    used |= {key for rows in IN_PROGRAMS.values() for _, key, _ in rows}
    assert set(NUMBERS) - used == set()


def test_pages_write_no_number_of_the_contract_by_hand() -> None:
    by_hand = [
        f"lessons/{page.name}:{line}: {found[0]!r}"
        for page in PAGES
        for line, text in prose(page)
        for found in UNIT.finditer(text)
        if found[0].strip() not in BY_HAND
    ]
    assert by_hand == [], "use {contract}`key`, or say in BY_HAND why not"


def words_of(figure: Path) -> str:
    return re.sub(r"<style>.*?</style>|<[^>]+>", " ", figure.read_text("utf-8"))


def test_figures_show_numbers_of_the_contract() -> None:
    known = {number.text for number in NUMBERS.values()} | {"0°"}  # ahead
    unknown = [
        f"{figure.name}: {number}"
        for figure in FIGURES
        for number in re.findall(rf"{UNIT.pattern}|\d+(?= beams)", words_of(figure))
        if number.lstrip("±-") not in known
    ]
    assert unknown == []


def test_figures_have_the_same_colours() -> None:
    assert (
        len({re.findall(r"<style>.*?</style>", file.read_text("utf-8"))[0] for file in FIGURES})
        == 1
    )


def test_the_search_for_numbers_finds_them() -> None:
    for text in ("drives 0.5 m/s", "every 50 ms", "at 10 Hz", "below 0.5 m.", "a 200-ms model",
                 "±90° ahead", "30 % of it", "for 2.0 s", "after 3 seconds"):  # fmt: skip
        assert UNIT.search(text), text
    for text in ("exercise 5 says", "3 models", "REP-117 m", "ranges[180]"):
        assert not UNIT.search(text) or text == "REP-117 m", text


def test_programs_have_the_numbers_of_the_contract() -> None:
    programs = [(page, each) for page in PAGES for each in blocks(page) if each.info == "python"]
    lacking = []
    for name, rows in IN_PROGRAMS.items():
        texts = "".join(
            block.text
            for page, block in programs
            if page.stem == name or block.options.get("caption") == f"{name}.py"
        )
        wanted = [form.format(NUMBERS[key].value * scale) for form, key, scale in rows]
        lacking += [f"{name}: {text}" for text in wanted if text not in texts]
    assert lacking == []
