"""A scenario by hand: the course's own, and what a person did in a drive of it.

A deed is an object with the time `at` [s] and one of: `sets` ("speed:=0.2") of a `node`; `e_stop`,
true or false; `goal`, x and y [m]; `covers`, how long no scan comes [s]; `box`, where one stands
from the start on, x and y [m].
"""

from __future__ import annotations

import cmath
import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

from grader.drive.as_toml import entry
from grader.recording.hands import SETTER
from sim.scenario_files import tables_of
from sim.toml_input import parse_toml, read_toml
from sim.world import world_names

Tables = dict[str, Any]
SIDE = 0.4  # [m] of a box


def scenario_by_hand(name: str, deeds: Sequence[Mapping[str, Any]]) -> str:
    """Return the TOML of the scenario of that name, with deeds.

    Raises InputError: no scenario is called that.
    """
    own, full = tables_of(name)
    doc = {**own, "title": f"{full['title']}, by hand"}
    script, covered, boxes = [*full.get("script", [])], [], []
    for deed in deeds:
        at = float(deed["at"])
        if "e_stop" in deed:
            script.append({"at": at, "e_stop": deed["e_stop"]})
        if "goal" in deed:
            script.append({"at": at, "goal": [*_turned_back(deed["goal"], full), 0.0]})
        if "covers" in deed:
            covered.append([at, round(at + deed["covers"], 3)])
        if "box" in deed:
            boxes.append({"center": _turned_back(deed["box"], full), "size": [SIDE, SIDE]})
    if script != full.get("script", []):
        doc["script"] = script
    if sets := [deed for deed in deeds if "sets" in deed]:
        nodes = dict.fromkeys(deed["node"] for deed in sets)
        doc["program"] = [*full.get("program", [{}]), *(_setter(node, sets) for node in nodes)]
    if covered:
        faults = full.get("faults", {})
        doc["faults"] = {**faults, "blackout": [*faults.get("blackout", []), *covered]}
    if boxes:
        world = full.get("world", {})
        if isinstance(world, str):
            world = parse_toml(read_toml(world_names()[world]), world)
        doc["world"] = {**world, "boxes": [*world.get("boxes", []), *boxes]}
    return "\n".join([*itertools.starmap(entry, doc.items()), ""])


def _setter(node: str, sets: Sequence[Mapping[str, Any]]) -> Tables:
    """Return the program that sets these parameters of a node."""
    mine = sorted((deed for deed in sets if deed["node"] == node), key=lambda deed: deed["at"])
    orders = [f"{float(deed['at'])} {deed['sets']}" for deed in mine]
    return {"file": SETTER, "supplied": True, "arguments": [node, *orders]}


def _turned_back(place: Sequence[float], full: Tables) -> list[float]:
    """Return where a place on the map lies before the scenario mirrors and turns its world."""
    there = complex(*place) * cmath.rect(1.0, math.radians(-full.get("rotate_deg", 0.0)))
    return [round(there.real, 3), round(-there.imag if full.get("mirror") else there.imag, 3)]
