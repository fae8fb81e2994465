"""Parameters that somebody asked for: does a node declare them, and does it get these values?"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable
from typing import Any

import yaml
from rclpy.node import Node

from .frames import Note, ProgramStart
from .robot_ends import ROBOT_NODE
from .wire import sendable


def watch(
    programs: Iterable[ProgramStart],
    running: Callable[[], ProgramStart],
    note: Callable[[Note], None],
) -> None:
    """Note each parameter that is asked for, until a node declares it, and if it gets another."""
    for name, value in {name: value for p in programs for name, value in p.asked.items()}.items():
        note(_note(name, more=value))
    cls: Any = Node
    declare = cls.declare_parameters

    @functools.wraps(declare)
    def declare_and_look(node: Any, *args: Any, **kwargs: Any) -> Any:
        declared = declare(node, *args, **kwargs)
        asked = {} if node.get_name() == ROBOT_NODE else running().asked
        for name, value in [(each.name, each.value) for each in declared if each.name in asked]:
            note(_note(name))
            more = "" if _is(value, asked[name]) else f"{value!r}, not {asked[name]}"
            note(_note(name, node.get_fully_qualified_name(), more))
        return declared

    cls.declare_parameters = declare_and_look


def _note(name: str, node: str = "", more: str = "") -> Note:
    about, more = (sendable(text)[: Note.MAX_NAME] for text in (name, more))
    return Note("asked", about, node, count=0, more=more)


def _is(value: Any, text: str) -> bool:
    """Return whether rcl may have read a value in a text; it reads some YAML differently."""
    try:
        read = yaml.safe_load(text)
    except yaml.YAMLError:
        return True
    if isinstance(read, list):
        return hasattr(value, "__iter__") and list(value) == read
    doubtful = isinstance(read, str) and not isinstance(value, str)  # 1e3, y
    return doubtful or str(value) in (text, str(read)) or value == read
