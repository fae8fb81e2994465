"""How a wrapper gets between a node and its topics.

Like the operators, these functions go as source text into the file of a node: they need nothing but
what stands in them, and the class `Node` of rclpy, which they are given.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any


def hears(node_class: Any, topic: str, change: Callable[[Any, float], list[Any]]) -> None:
    """Put a change between a topic and every callback that subscribes to it.

    One that expires makes something empty up when nothing has come for so many seconds.
    """
    create = node_class.create_subscription

    def create_subscription(
        node: Any, msg_type: Any, name: str, callback: Any, *args: Any, **kwargs: Any
    ) -> Any:
        if name.strip("/") != topic.strip("/"):
            return create(node, msg_type, name, callback, *args, **kwargs)
        expires = getattr(getattr(change, "change", None), "__name__", "") == "expires"
        silence = change.amount if expires else None  # type: ignore[attr-defined]

        def changed(message: Any) -> Any:
            if silence is not None:
                watchdog.reset()
            result = None
            for heard in change(message, node.get_clock().now().nanoseconds * 1e-9):
                result = callback(heard)
            return result

        def empty() -> None:
            watchdog.cancel()
            callback(msg_type())

        if silence is not None:
            watchdog = node.create_timer(silence, empty)
            watchdog.cancel()
        return create(node, msg_type, name, changed, *args, **kwargs)

    node_class.create_subscription = create_subscription


def says(node_class: Any, topic: str, change: Callable[[Any, float], list[Any]]) -> None:
    """Put a change between a node and the topic on which it publishes."""
    create = node_class.create_publisher

    def create_publisher(node: Any, msg_type: Any, name: str, *args: Any, **kwargs: Any) -> Any:
        publisher = create(node, msg_type, name, *args, **kwargs)
        if name.strip("/") == topic.strip("/"):
            publish = publisher.publish

            def changed(message: Any) -> None:
                for said in change(message, node.get_clock().now().nanoseconds * 1e-9):
                    publish(said)

            publisher.publish = changed
        return publisher

    node_class.create_publisher = create_publisher


def at(path: str, make: Callable[[], Any]) -> Callable[[Any, float], list[Any]]:
    """Change one number of a message ("linear.x"), or each of a list of numbers ("ranges")."""
    *parents, name = path.split(".")
    operators: list[Any] = []

    def change(message: Any, t: float) -> list[Any]:
        message = copy.deepcopy(message)
        owner = message
        for parent in parents:
            owner = getattr(owner, parent)
        value = getattr(owner, name)
        numbers = [value] if isinstance(value, float) else list(value)
        while len(operators) < len(numbers):
            operators.append(make())
        changed = [op(n, t) for op, n in zip(operators, numbers, strict=False)]
        setattr(owner, name, changed[0] if isinstance(value, float) else changed)
        return [message]

    return change
