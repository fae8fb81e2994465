"""Questions about the graph: who has which topics, services and actions."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from .endpoints import End, Publisher, Subscription
from .errors import NodeNameNonExistentError
from .graph import dds_type

if TYPE_CHECKING:
    from .node import Node

NamesAndTypes = list[tuple[str, list[str]]]

ACTION_FEEDBACK = "/_action/feedback"
FEEDBACK_MESSAGE = "_FeedbackMessage"
PUBLISHER, SUBSCRIPTION = 1, 2  # rmw_endpoint_type_t
KEEP_LAST_UNKNOWN = 3  # DDS doesn't tell others of history and depth
GID_SIZE = 16  # [bytes]


def _listed(pairs: Iterable[tuple[str, str]]) -> NamesAndTypes:
    found: dict[str, set[str]] = {}
    for name, kind in pairs:
        found.setdefault(name, set()).add(kind)
    return [(name, sorted(kinds)) for name, kinds in sorted(found.items())]


def _of_node(ends: Iterable[End], node: Node, name: str, namespace: str, what: str) -> list[Any]:
    known = node.get_node_names_and_namespaces()
    if (name, namespace) not in known:
        raise NodeNameNonExistentError(
            f"cannot get {what} names and types for nonexistent node: "
            f"no node {namespace.rstrip('/')}/{name}"
        )
    return [
        end
        for end in ends
        if (end.node.get_node_name(), end.node.get_namespace()) == (name, namespace)
    ]


def _topics(ends: Iterable[End], no_demangle: bool) -> NamesAndTypes:
    if no_demangle:
        return _listed((f"rt{end.topic}", dds_type(end.cls)) for end in ends)
    return _listed((end.topic, end.type_name) for end in ends)


def topics(node: Node, no_demangle: bool) -> NamesAndTypes:
    """Return all topics with their types; with `no_demangle` under DDS's names."""
    graph = node.participant
    found = _topics([*graph.all_publishers(), *graph.all_subscriptions()], no_demangle)
    if not no_demangle:
        return found
    requests = []
    for end in (*graph.all_services(), *graph.all_clients()):
        for prefix, part in (("rq", "Request"), ("rr", "Reply")):
            kind = dds_type(end.cls).removesuffix("_")
            suffix = "Request" if part == "Request" else "Response"
            requests.append((f"{prefix}{end.topic}{part}", f"{kind}_{suffix}_"))
    return sorted(found + _listed(requests))


def published_by(node: Node, no_demangle: bool, name: str, namespace: str) -> NamesAndTypes:
    """Return what a node publishes."""
    ends = node.participant.all_publishers()
    return _topics(_of_node(ends, node, name, namespace, "publisher"), no_demangle)


def subscribed_by(node: Node, no_demangle: bool, name: str, namespace: str) -> NamesAndTypes:
    """Return what a node subscribes to."""
    ends = node.participant.all_subscriptions()
    return _topics(_of_node(ends, node, name, namespace, "subscriber"), no_demangle)


def services(node: Node) -> NamesAndTypes:
    """Return all services with their types."""
    graph = node.participant
    return _topics([*graph.all_services(), *graph.all_clients()], False)


def served_by(node: Node, name: str, namespace: str) -> NamesAndTypes:
    """Return the services of a node."""
    ends = node.participant.all_services()
    return _topics(_of_node(ends, node, name, namespace, "service"), False)


def asked_by(node: Node, name: str, namespace: str) -> NamesAndTypes:
    """Return the services that a node is a client of."""
    ends = node.participant.all_clients()
    return _topics(_of_node(ends, node, name, namespace, "client"), False)


def _actions(ends: Iterable[End]) -> NamesAndTypes:
    return _listed(
        (end.topic.removesuffix(ACTION_FEEDBACK), end.type_name.removesuffix(FEEDBACK_MESSAGE))
        for end in ends
        if end.topic.endswith(ACTION_FEEDBACK)
    )


def actions(node: Node) -> NamesAndTypes:
    """Return all actions with their types."""
    graph = node.participant
    return _actions([*graph.all_publishers(), *graph.all_subscriptions()])


def actions_served_by(node: Node, name: str, namespace: str) -> NamesAndTypes:
    """Return the actions that a node serves."""
    ends = node.participant.all_publishers()
    return _actions(_of_node(ends, node, name, namespace, "publisher"))


def actions_asked_by(node: Node, name: str, namespace: str) -> NamesAndTypes:
    """Return the actions that a node asks for."""
    ends = node.participant.all_subscriptions()
    return _actions(_of_node(ends, node, name, namespace, "subscriber"))


def _info(end: Publisher | Subscription) -> dict[str, Any]:
    profile = end.profile.resolved()
    profile.history, profile.depth = KEEP_LAST_UNKNOWN, 0
    return {
        "node_name": end.node.get_node_name(),
        "node_namespace": end.node.get_namespace(),
        "topic_type": end.type_name,
        "topic_type_hash": {"version": 0, "value": bytes(32)},  # not known here
        "endpoint_type": PUBLISHER if isinstance(end, Publisher) else SUBSCRIPTION,
        "endpoint_gid": list(end.gid.to_bytes(GID_SIZE, "big")),
        "qos_profile": profile.to_dict(),
    }


def publishers_of(node: Node, topic: str, no_mangle: bool) -> list[dict[str, Any]]:
    """Describe the publishers of a topic."""
    return [_info(end) for end in node.participant.all_publishers() if end.topic == topic]


def subscriptions_of(node: Node, topic: str, no_mangle: bool) -> list[dict[str, Any]]:
    """Describe the subscriptions to a topic."""
    return [_info(end) for end in node.participant.all_subscriptions() if end.topic == topic]
