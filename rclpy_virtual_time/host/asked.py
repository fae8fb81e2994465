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

EACH_HAS = ("use_sim_time", "start_type_description_service", "qos_overrides.")
MOST_SAID = 8  # names of each kind


def watch(
    programs: Iterable[ProgramStart],
    running: Callable[[], ProgramStart],
    note: Callable[[Note], None],
) -> None:
    """Note the parameters that are asked for and that no node declares, and if one gets another.

    What a node was given is asked of rclpy: it has read command line, files and their sections. A
    node that takes undeclared ones has them all.
    """
    wanted = dict.fromkeys(name for program in programs for name in program.asked or ())
    declared: dict[str, None] = {}
    cls: Any = Node
    declare = cls.declare_parameters

    @functools.wraps(declare)
    def declare_and_look(node: Any, *args: Any, **kwargs: Any) -> Any:
        found = declare(node, *args, **kwargs)
        asked = None if node.get_name() == ROBOT_NODE else running().asked
        if asked is None:
            return found
        for name, value in [(each.name, each.value) for each in found if each.name in asked]:
            more = "" if _is(value, asked[name]) else f"{value!r}, not {asked[name]}"
            note(_note(name, node.get_fully_qualified_name(), more))
        wanted.update(dict.fromkeys(node._parameter_overrides))
        declared.update(dict.fromkeys(node._parameters))
        if node._allow_undeclared_parameters:
            declared.update(dict.fromkeys(node._parameter_overrides))
        if wanted:
            look()
        return found

    def look() -> None:
        missing = [name for name in wanted if name not in declared]
        own = [name for name in declared if not name.startswith(EACH_HAS)]
        more = Note.DECLARED.join(", ".join(names[:MOST_SAID]) for names in (missing, own))
        note(_note("undeclared", more=more if missing else ""))

    if wanted:
        look()
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
