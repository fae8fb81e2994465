"""Messages made of .msg text: as rosidl's own, by the bytes and hashes of rosbags."""

import copy
import importlib
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import rosidl_generator_type_description as rosidl
import std_srvs
from geometry_msgs.msg import Point
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosidl_parser import definition as idl

from rclpy_virtual_time.host import packages, stand_ins
from rclpy_virtual_time.host.interfaces import define, definitions

INNER = "string<=5 short\nbool yes true\nbyte one\nint64 big -9"
OUTER = """
uint8 ALL=3  # a constant
string WORD="two words"
Inner inner
Inner[] many
Inner[2] two
std_msgs/Header header
geometry_msgs/Point[<=3] points
float64[3] fixed
float32[] free
uint16[<=4] few
string[] words
bool[2] flags
int8 last
"""
PACKAGE = "course_test_msgs"


@pytest.fixture
def module(monkeypatch: pytest.MonkeyPatch) -> Any:
    found: Any = type(sys)(f"{PACKAGE}.msg")
    monkeypatch.setitem(sys.modules, PACKAGE, type(sys)(PACKAGE))
    monkeypatch.setitem(sys.modules, found.__name__, found)
    vars(found).update(define(PACKAGE, {"Inner": INNER, "Outer": OUTER}))
    return found


def store(texts: dict[str, str]) -> Any:
    found = get_typestore(Stores.ROS2_JAZZY)
    types: dict[str, Any] = {}
    for name, text in texts.items():
        types |= get_types_from_msg(text, name)
    found.register({name: each for name, each in types.items() if name not in found.types})
    return found


def test_every_kind_of_field_has_the_bytes_and_the_hash_of_the_real_one(module: Any) -> None:
    message = module.Outer(words=["a", "bc"], free=[1.5, 2.5], few=[7], points=[Point(x=1.0)])
    message.inner.short, message.inner.one = "abc", b"\x07"
    message.many = [module.Inner(yes=False), module.Inner(big=5)]
    message.fixed[1], message.header.frame_id, message.last = 2.0, "map", -3
    texts = {f"{PACKAGE}/msg/Inner": INNER, f"{PACKAGE}/msg/Outer": OUTER}
    theirs, name = store(texts), f"{PACKAGE}/msg/Outer"
    found = theirs.deserialize_cdr(serialize_message(message), name)
    assert [found.inner.short, found.inner.big] == ["abc", -9]
    assert [each.yes for each in found.many] == [False, True]
    assert [*found.fixed, *found.free, *found.few, found.last] == [0, 2, 0, 1.5, 2.5, 7, -3]
    again = deserialize_message(bytes(theirs.serialize_cdr(found, name)), module.Outer)
    assert again == message == copy.deepcopy(message)
    assert again != module.Outer()
    assert f"RIHS01_{definitions.rihs01(name, module.Outer).hex()}" == theirs.hash_rihs01(name)
    assert (module.Outer.ALL, message.WORD) == (3, "two words")
    assert module.Outer.get_fields_and_field_types()["points"] == (
        "sequence<geometry_msgs/Point, 3>"
    )
    assert isinstance(message.fixed, np.ndarray)
    message.few.extend(range(4))
    with pytest.raises(RuntimeError):  # it has grown too long
        serialize_message(message)


@pytest.mark.parametrize(
    ("field", "value"),
    [("inner", 3), ("many", ["a"]), ("words", "abc"), ("words", [1]), ("header", None),
     ("few", range(5)), ("points", [Point()] * 4), ("fixed", [1.0]), ("flags", [True] * 3)],
)  # fmt: skip
def test_what_can_not_stand_in_a_field_is_refused(module: Any, field: str, value: Any) -> None:
    with pytest.raises(AssertionError, match=field):
        setattr(module.Outer(), field, value)
    with pytest.raises(AttributeError):
        module.Outer().nothing = 1


def test_an_object_with_the_names_of_a_fields_type_can_be_sent(module: Any) -> None:
    alike = SimpleNamespace(short="abc", yes=True, one=b"1", big=-9)
    again = deserialize_message(serialize_message(module.Outer(inner=alike)), module.Outer)
    assert (again.inner.short, again.inner.big) == ("abc", -9)


@pytest.mark.parametrize(
    ("kind", "text", "said"),
    [
        ("msg", "float64", "Bad.msg, line 1: 'float64': expected TYPE name"),
        ("msg", "# a\nint8 a\nint8 a", "Bad.msg, line 3: .*there is a field a already"),
        ("msg", f"#{' ' * 90_000}x\nint8 {60 * 'A'}a=1", "line 2: .*a constant's name in capitals"),
        ("msg", "flot a", "line 1: 'flot a': there is no such type: expected bool, "),
        ("msg", "int8 class", "line 1: .*class is a word of Python's: colcon builds it, but"),
        ("msg", "uint8 a 256", "Bad.msg, line 1: .*<= 255"),
        ("msg", "string<=3 a 'abcd'", "Bad.msg, line 1: .*maximum length of 3"),
        ("msg", "time when", "in ROS 2 it is builtin_interfaces/Time"),
        ("msg", "Header header", "own has no message Header; in ROS 2 it is std_msgs/Header"),
        ("msg", "std_msgs/Strnig a", "line 1: std_msgs has no message Strnig"),
        ("msg", "Bad[] inner", "part of itself, .*: Bad in Bad"),
        ("msg", "Deep a\nint8[99999999] b", "more than 10,000,000 values"),
        ("msg", "float64[8000] a\nsensor_msgs/Imu[999999] b", "line 2: a message of more than"),
        ("srv", "bool a", "Bad.srv: expected 1 line ---, found 0"),
        ("srv", "bool a\n--\nbool b", "Bad.srv, line 2: '--': expected --- and nothing else"),
        ("action", "bool a\n---\n---\n---", "Bad.action: expected 2 lines ---"),
        ("msg", "# " + 100_000 * "a", "Bad.msg: at most 100,000 bytes"),
        ("msg", "no_such_msgs/Thing a", "line 1: there is no package no_such_msgs here"),
    ],
)
def test_a_package_with_a_wrong_definition(
    kind: str, text: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "own" / kind
    folder.mkdir(parents=True)
    (folder / f"Bad.{kind}").write_text(text)
    if kind == "msg":
        (folder / "Deep.msg").write_text("float64[100] a\nDeeper b")
        (folder / "Deeper.msg").write_text("int8 a")
    monkeypatch.setattr(sys, "meta_path", list(sys.meta_path))
    packages.offer([tmp_path])
    try:
        with pytest.raises(ImportError, match=said):
            getattr(importlib.import_module(f"own.{kind}"), "Bad")  # noqa: B009
    finally:
        for name in ("own", f"own.{kind}"):
            sys.modules.pop(name, None)


def test_a_service_has_the_hash_of_the_installed_one() -> None:
    share = Path(std_srvs.__file__).parents[4] / "share"
    for file in [share / "std_srvs" / "srv" / f"{name}.srv" for name in ("Empty", "SetBool")]:
        cls = define("std_srvs", {file.stem: file.read_text()}, "srv")[file.stem]
        there = json.loads(file.with_suffix(".json").read_text())["type_hashes"][0]["hash_string"]
        assert f"RIHS01_{definitions.rihs01(f'std_srvs/srv/{file.stem}', cls).hex()}" == there


def test_an_action_has_the_hash_of_rosidl(module: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    text, made = "int32 to\n---\nstring<=9[<=2] why\n---\nInner[2] last", type(sys)("action")
    monkeypatch.setitem(sys.modules, f"{PACKAGE}.action", made)
    vars(made).update(define(PACKAGE, {"Do": text}, "action"))
    described: dict[str, Any] = {}
    rosidl.add_action(definitions.parse(PACKAGE, "action", "Do", text), described)
    for name, cls in definitions.referenced(made.Do).items():
        fields = [idl.Member(kind, field) for field, kind in definitions.fields_of(cls)]
        described.setdefault(name, rosidl.GenericInterface(definitions.type_of(cls), fields))
    described = {n: rosidl.serialize_individual_type_description(
        idl.NamespacedType(n.split("/")[:2], n.split("/")[2]), each.members,
    ) for n, each in described.items()}  # fmt: skip
    whole = rosidl.extract_full_type_description(f"{PACKAGE}/action/Do", described)
    mine = definitions.rihs01(f"{PACKAGE}/action/Do", made.Do).hex()
    assert f"RIHS01_{mine}" == rosidl.calculate_type_hash(whole)


@pytest.fixture(params=["ackermann_msgs", "example_interfaces", "tf2_msgs", "vision_msgs"])
def package(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    monkeypatch.syspath_prepend(str(stand_ins.FOLDER))
    yield importlib.import_module(f"{request.param}.msg")
    for name in [n for n in sys.modules if n.partition(".")[0] in stand_ins.NAMES]:
        del sys.modules[name]


def test_the_packages_that_we_supply_can_be_sent(package: Any) -> None:
    for name, cls in vars(package).items():
        if isinstance(cls, type):
            assert deserialize_message(serialize_message(cls()), cls) == cls(), name
