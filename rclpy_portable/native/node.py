"""A node: a name, what the command line says of it, and questions about the graph."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from . import names, queries
from .arguments import NODE_NAMES, TOPIC, Arguments, Rule, parse
from .context import Context
from .errors import RCLError, RCLInvalidROSArgsError
from .handles import Destroyable


class Node(Destroyable):
    """A node of a context."""

    def __init__(
        self,
        name: str,
        namespace: str,
        context: Context,
        cli_args: Sequence[str] | None,
        use_global_arguments: bool,
        _enable_rosout: bool,
    ) -> None:
        if not context.ok():
            raise RCLError("error creating node: rcl context is not valid")
        namespace = namespace if namespace.startswith("/") else f"/{namespace}"
        own = _own_arguments(list(cli_args or ()))
        general = context.arguments if use_global_arguments else Arguments()
        self.rules: list[Rule] = [*own.rules, *general.rules]  # its own come first
        name = self._renamed(name, NODE_NAMES, name)
        namespace = self._renamed(name, ("__ns",), namespace)
        if problem := names.node_name_problem(name):
            raise ValueError(f"error creating node: invalid node name: {problem[0]}")
        if problem := names.namespace_problem(namespace):
            raise ValueError(f"error creating node: invalid namespace: {problem[0]}")
        self._name = name
        self._namespace = namespace
        self._arguments = general, own
        self.participant = context.participant
        self.participant.nodes.append(self)

    def resolve(self, name: str, scheme: str = TOPIC, *, remap: bool = True) -> str:
        """Return the full name of a topic, a service or an action, as its rules have it."""
        full = names.expand(name, self._name, self._namespace)
        return self.remap(full, scheme) if remap else full

    def remap(self, full: str, scheme: str = TOPIC) -> str:
        """Return what a full name becomes by the rules of the command line."""
        for rule in self.rules:
            if rule.before.startswith("__") or rule.node not in ("", self._name):
                continue
            if rule.scheme not in ("", scheme):
                continue
            if names.expand(rule.before, self._name, self._namespace) == full:
                return names.expand(rule.after, self._name, self._namespace)
        return full

    def _renamed(self, node: str, which: tuple[str, ...], default: str) -> str:
        fitting = (r for r in self.rules if r.before in which and r.node in ("", node))
        return next((rule.after for rule in fitting), default)

    def get_parameters(self, parameter: Any) -> dict[str, Any]:
        """Return the values that the command line gives, as instances of this class, by name."""
        full = self.get_fully_qualified_name()
        general, own = self._arguments
        values = general.of_node(full) | own.of_node(full)  # its own win
        kind = parameter.Type.from_parameter_value
        return {name: parameter(name, kind(value), value) for name, value in values.items()}

    def logger_name(self) -> str:
        """Return the name of its logger."""
        return self.get_fully_qualified_name().strip("/").replace("/", ".")

    def get_node_name(self) -> str:
        """Return its name."""
        return self._name

    def get_namespace(self) -> str:
        """Return its namespace."""
        return self._namespace

    def get_fully_qualified_name(self) -> str:
        """Return its name with the namespace."""
        return f"{self._namespace.rstrip('/')}/{self._name}"

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        """Return all nodes of the graph."""
        return [(node._name, node._namespace) for node in self.participant.all_nodes()]

    def get_node_names_and_namespaces_with_enclaves(self) -> list[tuple[str, str, str]]:
        """Return all nodes of the graph with their enclaves."""
        return [(node._name, node._namespace, "/") for node in self.participant.all_nodes()]

    def get_count_publishers(self, topic: str) -> int:
        """Return how many publishers a topic has."""
        return sum(end.topic == topic for end in self.participant.all_publishers())

    def get_count_subscribers(self, topic: str) -> int:
        """Return how many subscriptions a topic has."""
        return sum(end.topic == topic for end in self.participant.all_subscriptions())

    def get_count_services(self, name: str) -> int:
        """Return how many servers a service has."""
        return sum(end.topic == name for end in self.participant.all_services())

    def get_count_clients(self, name: str) -> int:
        """Return how many clients a service has."""
        return sum(end.topic == name for end in self.participant.all_clients())

    get_action_names_and_types = queries.actions
    get_action_server_names_and_types_by_node = queries.actions_served_by
    get_action_client_names_and_types_by_node = queries.actions_asked_by

    def _destroy(self) -> None:
        self.participant.nodes.remove(self)


def _own_arguments(words: list[str]) -> Arguments:
    try:
        return parse(words)
    except RCLError as error:
        raise RCLInvalidROSArgsError(f"Failed to parse ROS arguments: {error}") from None
