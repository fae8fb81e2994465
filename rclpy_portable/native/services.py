"""Services and clients: requests wait at the service, responses at the client that asked."""

from __future__ import annotations

import itertools
from collections import deque
from typing import TYPE_CHECKING, Any, NamedTuple

from .. import cdr
from . import machine
from .arguments import SERVICE
from .endpoints import End
from .handles import Destroyable
from .qos import rmw_qos_profile_t

if TYPE_CHECKING:
    from .node import Node


class rmw_request_id_t:  # noqa: N801  (its name in rclpy)
    """Which request of which client."""

    def __init__(self, client: Client, sequence_number: int) -> None:
        self.client = client
        self.sequence_number = sequence_number


class rmw_service_info_t:  # noqa: N801
    """What is known of a request or a response."""

    def __init__(self, request_id: rmw_request_id_t, source: int, received: int) -> None:
        self.request_id = request_id
        self.source_timestamp = source  # [ns] since 1970
        self.received_timestamp = received


class _Letter(NamedTuple):
    """A request or a response on its way."""

    data: bytes  # CDR
    id: rmw_request_id_t
    sent: int  # [ns] since 1970

    def info(self) -> rmw_service_info_t:
        return rmw_service_info_t(self.id, self.sent, self.sent)


class _ServiceEnd(End):
    """What services and clients have in common."""

    scheme = SERVICE
    what = ""

    def __init__(self, node: Node, cls: Any, name: str, qos: rmw_qos_profile_t | None) -> None:
        super().__init__(node, cls, name, qos)
        self.participant.claim(self.wire, cls.Request, self.what, "request topic")
        self.queue: deque[_Letter] = deque()

    @property
    def wire(self) -> str:
        """The name that requests have in DDS."""
        return f"rq{self.topic}Request"

    @property
    def ready(self) -> bool:
        """There is a request to take, or a response, perhaps to another's request."""
        return bool(self.queue)

    def configure_introspection(self, _clock: Any, _qos: Any, _state: Any) -> None:
        """Nobody publishes what services and clients do here."""


class Service(_ServiceEnd):
    """A service of a node."""

    what = "service"

    def __init__(self, node: Node, cls: Any, name: str, qos: rmw_qos_profile_t | None) -> None:
        super().__init__(node, cls, name, qos)
        self.participant.services.append(self)

    @property
    def name(self) -> str:
        """Its full name."""
        return self.topic

    @property
    def qos(self) -> dict[str, Any]:
        """The profile, as arguments of rclpy's QoSProfile."""
        return self.profile.to_dict()

    def service_take_request(self, cls: Any) -> tuple[Any, rmw_service_info_t | None]:
        """Return the oldest request, with the id under which its answer goes back."""
        if not self.queue:
            return None, None
        letter = self.queue.popleft()
        return cdr.deserialize(letter.data, cls), letter.info()

    def service_send_response(self, response: Any, request_id: rmw_request_id_t) -> None:
        """Answer a request.

        Every client of the service hears it and wakes up, as in DDS, where responses share one
        topic; those that did not ask drop it.
        """
        letter = _Letter(cdr.serialize(response), request_id, machine.stamps.next())
        for client in self.participant.all_clients():
            if client.topic == self.topic and client.cls is self.cls:
                client.queue.append(letter)
        machine.changed()

    def _destroy(self) -> None:
        self.participant.services.remove(self)
        self.participant.release(self.wire)


class Client(_ServiceEnd):
    """A client of a service."""

    what = "client"

    def __init__(self, node: Node, cls: Any, name: str, qos: rmw_qos_profile_t | None) -> None:
        super().__init__(node, cls, name, qos)
        self._numbers = itertools.count(1)
        self.participant.clients.append(self)

    @property
    def service_name(self) -> str:
        """The full name of the service."""
        return self.topic

    def service_server_is_available(self) -> bool:
        """Return whether somebody would answer."""
        return bool(self._servers())

    def send_request(self, request: Any) -> int:
        """Ask; return the number that the response will have."""
        number = next(self._numbers)
        letter = _Letter(
            cdr.serialize(request), rmw_request_id_t(self, number), machine.stamps.next()
        )
        for server in self._servers():
            server.queue.append(letter)
        machine.changed()
        return number

    def take_response(self, cls: Any) -> tuple[rmw_service_info_t | None, Any]:
        """Take the oldest response; return it if it answers this client."""
        if not self.queue:
            return None, None
        letter = self.queue.popleft()
        if letter.id.client is not self:
            return None, None
        return letter.info(), cdr.deserialize(letter.data, cls)

    def _servers(self) -> list[Service]:
        return [
            server
            for server in self.participant.all_services()
            if server.topic == self.topic and server.cls is self.cls
        ]

    def _destroy(self) -> None:
        self.participant.clients.remove(self)
        self.participant.release(self.wire)


class TypeDescriptionService(Destroyable):
    """The service by which others ask a node for the definition of a type. It knows none here."""

    def __init__(self, node: Node) -> None:
        from type_description_interfaces.srv import GetTypeDescription  # noqa: PLC0415

        profile = rmw_qos_profile_t.predefined("services_default")
        self.impl = Service(node, GetTypeDescription, "~/get_type_description", profile)

    def handle_request(self, _request: Any, response_cls: Any, _node: Node) -> Any:
        """Answer that the type is not known."""
        reason = "definitions of types are not kept in the portable runtime"
        return response_cls(successful=False, failure_reason=reason)
