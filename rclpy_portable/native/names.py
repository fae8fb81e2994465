"""Names of nodes, namespaces, topics and services: what is valid, and what they expand to.

The rules are those of rcl's validate_topic_name.c and expand_topic_name.c, and of rmw's
validate_*.c; so are the texts, because students read them.
"""

from __future__ import annotations

import re

Invalid = tuple[str, int] | None  # why, and at which character

SUBSTITUTION = re.compile(r"\{([^{}]*)\}")
MAX_TOPIC = 247  # [characters]; rmw keeps 8 of 255 for prefixes
MAX_NAMESPACE = 245
MAX_NODE = 255
MAX_TOPIC_TEXT, MAX_NAMESPACE_TEXT = "255U - 8U", "RMW_NAMESPACE_MAX_NAME_LENGTH"  # as rmw says it


def topic_name_problem(name: str) -> Invalid:
    """Tell what is wrong with a name that may be relative and hold `~` and substitutions."""
    if not name:
        return "topic name must not be empty string", 0
    if name[0].isdigit():
        return "topic name token must not start with a number", 0
    if name.endswith("/"):
        return "topic name must not end with a forward slash", len(name) - 1
    return _bad_character(name) or _bad_tilde(name) or _bad_token(name)


def full_topic_name_problem(name: str) -> Invalid:
    """Tell what is wrong with a name that must be absolute and complete."""
    found = _absolute_problem(name, "topic name")
    if found is None and len(name) > MAX_TOPIC:
        return f"topic length should not exceed '{MAX_TOPIC_TEXT}'", MAX_TOPIC - 1
    return found


def namespace_problem(name: str) -> Invalid:
    """Tell what is wrong with a namespace."""
    if name == "/":
        return None
    found = _absolute_problem(name, "namespace")
    if found is None and len(name) > MAX_NAMESPACE:
        return f"namespace should not exceed '{MAX_NAMESPACE_TEXT}'", MAX_NAMESPACE - 1
    return found


def node_name_problem(name: str) -> Invalid:
    """Tell what is wrong with the name of a node."""
    if not name:
        return "node name must not be empty", 0
    if bad := re.search(r"[^A-Za-z0-9_]", name):
        said = "node name must not contain characters other than alphanumerics or '_'"
        return said, bad.start()
    if name[0].isdigit():
        return "node name must not start with a number", 0
    if len(name) > MAX_NODE:
        return f"node name length should not exceed '{MAX_NODE}'", MAX_NODE - 1
    return None


def expand(name: str, node: str, namespace: str) -> str:
    """Return the absolute name that a node means.

    Raises ValueError: one of the three is not valid.
    """
    if topic_name_problem(name):
        raise ValueError(f"topic name is invalid: {name!r}")
    if node_name_problem(node):
        raise ValueError(f"node name is invalid: {node!r}")
    if namespace_problem(namespace):
        raise ValueError(f"node namespace is invalid: {namespace!r}")
    known = {"node": node, "ns": namespace, "namespace": namespace}

    def value(match: re.Match[str]) -> str:
        if match[1] not in known:
            raise ValueError(f"topic name is invalid: unknown substitution {match[0]}")
        return known[match[1]]

    top = "" if namespace == "/" else namespace
    if name.startswith("~"):
        name = f"{top}/{node}{name[1:]}"
    name = SUBSTITUTION.sub(value, name)
    return name if name.startswith("/") else f"{top}/{name}"


def _bad_character(name: str) -> Invalid:
    """Look at what stands outside of the braces, and at the braces."""
    opened = None
    for i, character in enumerate(name):
        if character == "{":
            if opened is not None:
                return "topic name must not have unmatched (unbalanced) curly braces '{}'", opened
            opened = i
        elif character == "}":
            if opened is None:
                return "topic name must not have unmatched (unbalanced) curly braces '{}'", i
            opened = None
        elif opened is not None:
            if not re.match(r"[A-Za-z0-9_]", character):
                said = "substitution name must not contain characters other than alphanumerics"
                return f"{said} or '_'", i
            if character.isdigit() and i == opened + 1:
                return "substitution name must not start with a number", i
        elif not re.match(r"[A-Za-z0-9_/~]", character):
            said = "topic name must not contain characters other than alphanumerics, '_', '~', '{',"
            return f"{said} or '}}'", i
    if opened is not None:
        return "topic name must not have unmatched (unbalanced) curly braces '{}'", opened
    return None


def _bad_tilde(name: str) -> Invalid:
    at = name.find("~", 1)
    if at > 0:
        return "topic name must not have tilde '~' unless it is the first character", at
    return None


def _bad_token(name: str) -> Invalid:
    if bad := re.search(r"/[0-9]", name):
        return "topic name token must not start with a number", bad.start() + 1
    return None


def _absolute_problem(name: str, what: str) -> Invalid:
    if not name:
        return f"{what} must not be empty", 0
    if not name.startswith("/"):
        return f"{what} must be absolute, it must lead with a '/'", 0
    if name.endswith("/"):
        unless = ", unless only a '/'" if what == "namespace" else ""
        return f"{what} must not end with a '/'{unless}", len(name) - 1
    if bad := re.search(r"[^A-Za-z0-9_/]", name):
        said = f"{what} must not contain characters other than alphanumerics, '_', or '/'"
        return said, bad.start()
    if "//" in name:
        return f"{what} must not contain repeated '/'", name.find("//") + 1
    if bad := re.search(r"/[0-9]", name):
        return f"{what} must not have a token that starts with a number", bad.start() + 1
    return None
