"""Messages made of .msg text: as rosidl's own, by the bytes and hashes of rosbags."""

import copy
import importlib
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Point
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from rclpy_virtual_time.host import stand_ins
from rclpy_virtual_time.host.interfaces import define, definitions

INNER = "string<=5 short\nbool yes true\nbyte one\nint64 big -9"
OUTER = """
uint8 ALL=3  # a constant
string WORD="two words"
Inner inner
Inner[] many
Inner[2] two
Header header
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


@pytest.mark.parametrize(
    ("field", "value"),
    [("inner", 3), ("many", ["a"]), ("words", "abc"), ("words", [1]), ("header", None)],
)
def test_what_can_not_stand_in_a_field_is_refused(module: Any, field: str, value: Any) -> None:
    with pytest.raises(AssertionError, match=field):
        setattr(module.Outer(), field, value)
    with pytest.raises(AttributeError):
        module.Outer().nothing = 1


def test_a_line_that_is_no_field_is_refused() -> None:
    with pytest.raises(ValueError, match="no field"):
        define(PACKAGE, {"Bad": "float64"})


@pytest.fixture(params=["ackermann_msgs", "tf2_msgs", "vision_msgs"])
def package(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    monkeypatch.syspath_prepend(str(stand_ins.FOLDER))
    yield importlib.import_module(f"{request.param}.msg")
    for name in [n for n in sys.modules if n.partition(".")[0] in stand_ins.NAMES]:
        del sys.modules[name]


def test_the_packages_that_we_supply_can_be_sent(package: Any) -> None:
    for name, cls in vars(package).items():
        if isinstance(cls, type):
            assert deserialize_message(serialize_message(cls()), cls) == cls(), name
